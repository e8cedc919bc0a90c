//! Formats of tables of numbers in files.

use std::io::BufReader;

use super::{NumberTable, parse};

fn from(bytes: &[u8], wanted: &[&str], dt: Option<f64>) -> Result<NumberTable, String> {
    let wanted: Vec<String> = wanted.iter().map(|&w| w.to_owned()).collect();
    parse("f".into(), bytes, &wanted, dt).map_err(|error| error.to_string())
}

fn table(text: &str, wanted: &[&str]) -> Result<NumberTable, String> {
    from(text.as_bytes(), wanted, Some(0.5))
}

#[test]
fn separators_are_sensed() {
    let plain = table("1,2\n3,4e0\n", &[]).unwrap();
    assert_eq!(
        (plain.names, plain.values),
        (vec!["1".into(), "2".into()], vec![1.0, 2.0, 3.0, 4.0])
    );
    for text in [
        "x,y\n1,2\n3,4\n",
        "\u{feff}# made by hand\r\nx;y\r\n1 ; 2\r\n\r\n3;4",
        "x\ty\n1\t2\n3\t4\n",
        "x\t\ty\n1\t\t2\n3\t\t4\n",
        "x y\n1 2\n3 4\n",
        "  x    y\n  1.0e+00   2.0D+00\n  3.0e+00   4.0d+00\n",
        "x, y\n1, 2\n3, 4\n",
        "\"x\",\"y\"\n1,2\n3,\"4\"\n",
        // Decimal commas, with another separator.
        "x;y\n1,0;2,0\n3,0;4,0\n",
        "x\ty\n1,0\t2\n3\t4,0\n",
        "x y\n1,0 2\n3 4,0\n",
        // Names in the last comment: gnuplot, TISEAN, MATLAB.
        "# by hand, in 2026\n# x y\n1 2\n3 4\n",
        "#x y\n1 2\n3 4\n",
        "% x   y\n1 2\n3 4\n",
        "# x, y\n1, 2\n3, 4\n",
    ] {
        let named = table(text, &[]).unwrap_or_else(|error| panic!("{text:?}: {error}"));
        assert_eq!(named.names, ["x", "y"], "{text:?}");
        assert_eq!(named.values, [1.0, 2.0, 3.0, 4.0], "{text:?}");
    }
    // A comment with other words is not a header.
    assert_eq!(
        table("# two columns here\n1 2\n3 4\n", &[]).unwrap().names,
        ["1", "2"]
    );
    // Nor is Octave's description of the file, even with as many words as columns.
    for (comments, rows, names) in [
        (
            "# name: x\n# type: matrix\n# rows: 3\n# columns: 1\n",
            "1\n2\n4\n",
            vec!["1"],
        ),
        ("% name: x\n", "1 2\n3 4\n", vec!["1", "2"]),
        ("# x:\n", "1\n2\n4\n", vec!["x:"]),
    ] {
        let table = table(&format!("{comments}{rows}"), &[]).unwrap();
        assert_eq!(table.names, names, "{comments:?}");
    }
    // A comma alone separates, unless the digits beside it cannot be whole numbers.
    assert_eq!(table("1,5\n2,5\n4,9\n", &[]).unwrap().names.len(), 2);
    // One column needs no separator.
    assert_eq!(
        table("1.5\n2.5\n4.5\n", &[]).unwrap().values,
        [1.5, 2.5, 4.5]
    );
    // Latin-1 in a comment is harmless.
    let latin = from(b"# Gr\xf6\xdfe\n1 2\n3 4\n", &[], Some(1.0)).unwrap();
    assert_eq!(latin.values, [1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn columns_are_chosen_by_number_or_name() {
    let text = "a,b,c\n1,2,3\n";
    let chosen = |text: &str, wanted: &[&str]| table(text, wanted).unwrap().values;
    assert_eq!(chosen(text, &["3", "a"]), [3.0, 1.0]);
    assert_eq!(table(text, &["b"]).unwrap().names, ["b"]);
    assert!(
        table(text, &["d"])
            .unwrap_err()
            .contains("1 to 3 (a, b, c)")
    );
    assert!(table(text, &["a", "1"]).unwrap_err().contains("twice"));
    assert_eq!(chosen(text, &[" c", "a "]), [3.0, 1.0]);
    let twins = "a,b,a\n1,2,3\n";
    let ambiguous = table(twins, &["b", "a"]).unwrap_err();
    assert!(
        ambiguous.contains("'a'") && ambiguous.contains("1 and 3"),
        "{ambiguous}"
    );
    assert_eq!(chosen(twins, &["3", "b"]), [3.0, 2.0]);
    // A column that is not read may contain anything.
    assert_eq!(chosen("n,x\none,1\ntwo,2\n", &["x"]), [1.0, 2.0]);
}

#[test]
fn a_time_column_is_checked_and_not_a_coordinate() {
    assert_eq!(table("t,x\n0,7\n0.5,8\n", &[]).unwrap().values, [7.0, 8.0]);
    let gap = table("Time,x\n0,7\n0.5,8\n1.5,9\n", &[]).unwrap_err();
    assert!(gap.starts_with("f, line 4, column 1 (Time): "), "{gap}");
    assert_eq!(table("t,x\n0,7\n9,8\n", &["t"]).unwrap().values, [0.0, 9.0]);
    let only = table("t\n0\n0.5\n", &[]).unwrap_err();
    assert!(only.contains("skipped as the time"), "{only}");
}

#[test]
fn a_time_column_says_what_the_step_is() {
    let without = |text: &str, wanted: &[&str]| from(text.as_bytes(), wanted, None);
    let rows = |step: f64, name: &str| {
        let rows = (0..50).map(|i| format!("{} {}\n", 3.0 + step * f64::from(i), (i * i) % 17));
        format!("{name} x\n{}", rows.collect::<String>())
    };
    // The sum of rounded times must not accumulate.
    for (name, step) in [
        ("t", 0.02),
        ("Time", 0.1),
        ("t(s)", 1e-3),
        ("time[ms]", 7.0),
    ] {
        let table = without(&rows(step, name), &[]).unwrap();
        assert_eq!((table.dt, table.names.len()), (step, 1), "{name}");
        assert!(table.time.is_some() && table.notes.is_empty());
    }
    // One third, to three digits.
    let thirds = without("t,x\n0.333,5\n0.667,7\n1.000,2\n", &[]).unwrap();
    assert!((thirds.dt - 1.0 / 3.0).abs() < 1e-3);
    let gap = without("t,x\n0,7\n1,8\n2,8\n4,1\n5,3\n", &[]).unwrap_err();
    assert!(
        gap.starts_with("f, line 5, column 1 (t): the time goes from 2 to 4"),
        "{gap}"
    );
    let back = without("t,x\n0,7\n1,8\n0.5,8\n2,1\n3,2\n", &[]).unwrap_err();
    assert!(back.contains("line 4"), "{back}");
    // A first column without a name and with equal steps.
    let unnamed = without("0 5\n0.25 7\n0.5 2\n", &[]).unwrap();
    assert_eq!(
        (unnamed.dt, &unnamed.names[..]),
        (0.25, &["2".to_owned()][..])
    );
    assert_eq!(unnamed.values, [5.0, 7.0, 2.0]);
    assert!(
        unnamed.notes[0].contains("--columns 1,2"),
        "{:?}",
        unnamed.notes
    );
    // If requested, it is a coordinate, and the step is unknown.
    let unknown = without("0 5\n0.25 7\n0.5 2\n", &["1", "2"]).unwrap_err();
    assert!(unknown.starts_with("--dt is missing"), "{unknown}");
    assert!(without("5 0\n7 3\n2 1\n", &[]).is_err());
    // A first column that differs from the given step, or that has gaps, is used if requested.
    // Otherwise a warning reports it.
    let quarters = |rows: usize| -> String {
        let row = |i: usize| format!("{} {}\n", 0.25 * i as f64, i * i % 7);
        (0..rows).map(row).collect()
    };
    let other = table(&quarters(10), &[]).unwrap_err();
    let says = "f: column 1 goes on by 0.25 from row to row, as a time does, while --dt is 0.5";
    assert!(
        other.starts_with(says) && other.contains("--columns 1,2"),
        "{other}"
    );
    let asked = table(&quarters(10), &["1", "2"]).unwrap();
    assert_eq!(asked.names.len(), 2);
    // So few may occur by chance.
    assert_eq!(table(&quarters(9), &[]).unwrap().names.len(), 2);
    let with_jumps = |every: usize| -> String {
        let row = |i: usize| format!("{} {}\n", 0.5 * (i + i / every) as f64, i * i % 7);
        (0..2000).map(row).collect()
    };
    for every in [1999, 600] {
        let gap = table(&with_jumps(every), &[]).unwrap_err();
        let says = format!(
            "but from {} to {} at row {}",
            0.5 * (every - 1) as f64,
            0.5 * (every + 1) as f64,
            every + 1
        );
        assert!(gap.contains(&says), "{gap}");
        assert_eq!(without(&with_jumps(every), &[]).unwrap_err(), gap);
    }
    // A column that rises in all rows is not a recurrent state, however many gaps it has.
    assert!(table(&with_jumps(150), &[]).is_err());
    let squares: String = (0..20).map(|i| format!("{} {}\n", i * i, i % 3)).collect();
    let uneven = table(&squares, &[]).unwrap_err();
    assert!(uneven.contains("but from 0 to 1 at row 2"), "{uneven}");
    // A phase that starts anew is a coordinate.
    let phase: String = (0..2000)
        .map(|i| format!("{} {}\n", 0.5 * f64::from(i % 150), i * i % 7))
        .collect();
    assert_eq!(table(&phase, &[]).unwrap().names.len(), 2);
    assert_eq!(table("0 5\n0.5 7\n1 2\n", &[]).unwrap().names.len(), 1);
}

#[test]
fn a_constant_column_is_left_out_with_a_word() {
    let left = table("x,y,z\n1,2,5\n3,2,4\n", &[]).unwrap();
    assert_eq!(
        (left.names.len(), left.values),
        (2, vec![1.0, 5.0, 3.0, 4.0])
    );
    assert_eq!(left.notes, ["column y is 2 in every row and is left out"]);
    // If all are constant, the estimator reports it.
    assert_eq!(table("1,2\n1,2\n", &[]).unwrap().names.len(), 2);
}

/// -0 and 05 are not whole numbers, so that the comma beside them is a decimal comma. With two
/// commas in a line the separator is ambiguous.
#[test]
fn a_decimal_comma_without_another_separator_is_recognized_by_its_digits() {
    let read = table("0,25\n-0,5\n1,05\n", &[]).unwrap();
    assert_eq!(read.values, [0.25, -0.5, 1.05]);
    assert!(read.notes[0].contains("decimal commas") && read.notes[0].contains("semicolons"));
    let read = table("0,25,1,5\n-0,5,2,5\n", &[]).unwrap_err();
    assert!(
        read.contains("line 1: commas separate the columns and are decimal commas"),
        "{read}"
    );
    // Whole numbers, an odd number of columns, points: columns.
    for (text, columns) in [
        ("0,25\n-3,50\n1,0\n", 2),
        ("0,05,1\n2,07,1\n", 3),
        ("-0,1.5\n1,2.5\n", 2),
    ] {
        let read = table(text, &[]).unwrap();
        let columns_read = read.values.len() / text.lines().count();
        let left_out = read
            .notes
            .iter()
            .filter(|note| note.contains("left out"))
            .count();
        assert_eq!(columns_read + left_out, columns, "{text:?}");
        assert!(
            !read.notes.iter().any(|note| note.contains("decimal")),
            "{text:?}"
        );
    }
}

#[test]
fn a_blank_line_between_numbers_is_reported_and_one_around_them_is_not() {
    let notes = |text: &str| table(text, &[]).unwrap().notes;
    let reported = notes("1 2\n3 4\n\n\n5 6\n7 9\n\n8 9\n");
    assert!(
        reported.len() == 1 && reported[0].starts_with("line 3 is blank"),
        "{reported:?}"
    );
    assert_eq!(notes("\n# two\n\n1 2\n3 4\n5 7\n\n\n"), [""; 0]);
}

#[test]
fn a_table_that_repeats_itself_has_a_period() {
    let sine = |rows: usize, period: f64| -> String {
        (0..rows)
            .map(|i| {
                format!(
                    "{}\n",
                    stickslip::math::sin(std::f64::consts::TAU * i as f64 / period)
                )
            })
            .collect()
    };
    let period = |text: &str| table(text, &[]).unwrap().period();
    assert_eq!(period(&sine(1000, 100.0)), Some(100));
    // 63 rows are 5.5 periods.
    assert_eq!(period(&sine(1000, 126.0 / 11.0)), Some(126));
    // It does not repeat twice.
    assert_eq!(period(&sine(199, 100.0)), None);
    assert_eq!(period(&sine(1000, 100.0 / std::f64::consts::SQRT_2)), None);
    // One of many numbers differs.
    assert_eq!(
        period(&(sine(700, 100.0) + "0.5\n" + &sine(300, 100.0))),
        None
    );
    // A constant first half agrees with itself.
    assert_eq!(period(&("0.5\n".repeat(500) + &sine(500, 70.7))), None);
}

#[test]
fn columns_that_count_are_found() {
    let even = |text| -> Vec<(usize, f64)> { table(text, &[]).unwrap().even_columns().collect() };
    // A rounded time is still a time.
    assert_eq!(even("0,1,9\n1,4,6\n2,9,3\n"), [(0, 1.0), (2, -3.0)]);
    assert_eq!(even("x\n0.333\n0.667\n1.000\n").len(), 1);
    assert_eq!(even("0,1\n1,1\n2.1,1\n"), []);
    assert_eq!(even("0,1\n1,2\n"), []);
}

/// Few bits with an offset; two values without a common step; all digits of a double.
#[test]
fn the_step_of_a_grid_is_found() {
    let grid = |of: &dyn Fn(u32) -> f64| {
        let row = |i: u32| format!("{:?}\n", of(i * i % 499 + i % 7 * (i % 11)));
        let text: String = (0..4000).map(row).collect();
        table(&text, &[]).unwrap().grid().map(|grid| grid.step)
    };
    assert_eq!(grid(&|k| 0.013 + 0.05 * f64::from(k)), Some(Some(0.05)));
    let volts = 10.0 / 4096.0;
    assert_eq!(grid(&|k| volts * f64::from(k) - 5.0), Some(Some(volts)));
    assert_eq!(grid(&|k| f64::from(k).sqrt()), Some(None));
    let mut chaos = 0.3;
    let rows = (0..2000).map(|_| {
        chaos = 3.9 * chaos * (1.0 - chaos);
        format!("{chaos:.9}\n")
    });
    assert_eq!(table(&rows.collect::<String>(), &[]).unwrap().grid(), None);
}

#[test]
fn arrays_of_numpy() {
    /// A header of version 1 and the bytes behind it.
    fn array(header: &str, numbers: &[u8]) -> Vec<u8> {
        let padded = header.len() + 10 + 1;
        let header = format!("{header}{}\n", " ".repeat((64 - padded % 64) % 64));
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(numbers);
        bytes
    }
    let doubles: Vec<u8> = [1.0_f64, 2.0, 3.0, 7.0, 5.0, 6.0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let header = |order: &str, shape: &str| {
        format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': {shape}, }}")
    };
    let read = |header: &str, numbers: &[u8]| from(&array(header, numbers), &[], Some(0.5));
    let by_rows = read(&header("False", "(3, 2)"), &doubles).unwrap();
    assert_eq!(by_rows.values, [1.0, 2.0, 3.0, 7.0, 5.0, 6.0]);
    let by_columns = read(&header("True", "(3, 2)"), &doubles).unwrap();
    assert_eq!(by_columns.values, [1.0, 7.0, 2.0, 5.0, 3.0, 6.0]);
    assert_eq!(
        read(&header("False", "(6,)"), &doubles).unwrap().names,
        ["1"]
    );
    let small = "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 2), }";
    assert_eq!(
        read(small, &[1, 9, 3, 4]).unwrap().values,
        [1.0, 9.0, 3.0, 4.0]
    );
    let whole: Vec<u8> = [1_i64, -2, 3, 7]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let default = "{'descr': '<i8', 'fortran_order': False, 'shape': (2, 2), }";
    assert_eq!(read(default, &whole).unwrap().values, [1.0, -2.0, 3.0, 7.0]);
    for (header, numbers, says) in [
        (
            header("False", "(3, 2)"),
            &doubles[..40],
            "f is a .npy array, but it ends before its last number",
        ),
        (
            header("False", "(3, 2, 1)"),
            &doubles[..],
            "its shape is [3, 2, 1]",
        ),
        (
            header("False", "(999999999999, 9)"),
            &doubles[..],
            "at most",
        ),
        (header("False", "(0, 2)"), &doubles[..], "holds no data"),
        (
            "{'descr': '<c16', 'fortran_order': False, 'shape': (3,), }".into(),
            &doubles[..],
            "save it as float64",
        ),
        (
            "{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (6,), }".into(),
            &doubles[..],
            "structured",
        ),
        ("nonsense".into(), &doubles[..], "f is a .npy array, but "),
        (
            format!("{{'descr': {} }}", "{".repeat(20)),
            &doubles[..],
            "brackets 21 deep, at most 4",
        ),
        (
            " ".repeat(10_001),
            &doubles[..],
            "bytes, at most 10000 are read",
        ),
    ] {
        let error = read(&header, numbers).unwrap_err();
        assert!(error.contains(says), "{header}: {error}");
    }
    let error = from(b"\x93NUMPY\x01\x00v\x00{'descr'", &[], None).unwrap_err();
    assert!(error.contains("ends within its header"), "{error}");
    let nan: Vec<u8> = [1.0, f64::NAN]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let error = read(&header("False", "(1, 2)"), &nan).unwrap_err();
    assert!(error.contains("row 1, column 2"), "{error}");
}

#[test]
fn bad_files_are_named_by_line_and_column() {
    let wide = "1,".repeat(999_999) + "1\n2";
    let bad: &[(&[u8], &str)] = &[
        (
            b"x,y\n1,2\n3,oops\n",
            "f, line 3, column 2 (y): 'oops' is not a number",
        ),
        (
            b"#\n1,2\n\n# gap\r\n3,\n",
            "f, line 5, column 2: the cell is empty",
        ),
        (b"1,2\n3,nan\n", "f, line 2, column 2: 'nan' is not finite"),
        (b"1,2\n3,inf\n", "f, line 2, column 2: 'inf' is not finite"),
        (
            b"1,2\n3,1e999\n",
            "f, line 2, column 2: '1e999' is not finite",
        ),
        (
            b"1,2\n3\n",
            "f, line 2, column 2: the line has 1 columns, separated by commas",
        ),
        (
            b"1 2\n3\n",
            "f, line 2, column 2: the line has 1 columns, separated by spaces",
        ),
        (
            b"1;2\n3;4;5\n",
            "f, line 2, column 3: the line has 3 columns, separated by semicolons",
        ),
        (b"1\t2\n3\t\n", "f, line 2, column 2: the cell is empty"),
        (b"1\t2\n\t4\n", "f, line 2, column 1: the cell is empty"),
        (
            b"x y z\n1 2\n",
            "f, line 2, column 3 (z): the line has 2 columns",
        ),
        (b"", "f holds no data"),
        (b"\n\n \n", "f holds no data"),
        (b"# only\n% comments\n", "f holds no data"),
        (b"\xef\xbb\xbf", "f holds no data"),
        (b"x,y\n", "f holds no data"),
        (b"x\n", "f holds no data"),
        (
            b"1,oops\n3,4\n",
            "f, line 1, column 2: 'oops' is not a number",
        ),
        (
            b"1;2.5\n1,5;2\n",
            "f, line 2, column 1: '1,5' may have a decimal comma",
        ),
        (
            b"1 2.5\n1,5 2\n",
            "f, line 2, column 1: '1,5' may have a decimal comma",
        ),
        (b"1;1,2,3\n1;2,5\n", "f, line 1, column 2: '1,2,3' may have"),
        (
            b"1 2 3 4 5 6 7 8 9 10 12\n",
            "f has one row of 11 numbers, and a row is a state: write each state in a line",
        ),
        (
            b"0,5,-0,25\n1,5,2,5\n",
            "f, line 1: commas separate the columns and are decimal commas, too",
        ),
        (b"1,2\n3,\xff\n", "f, line 2: the text is not UTF-8"),
        (b"a\xff,b\n3,4\n", "f, line 1: the text is not UTF-8"),
        (b"\xff\xfe1\0,\x002\0\n\0", "f is UTF-16"),
        (b"\xfe\xff\x001\0,\x002\0\n", "f is UTF-16"),
        (b"1\0,\x002\0\n\0", "f is no text"),
        (
            b"\x1f\x8b\x08\0\0\0",
            "f is compressed by gzip; unpack it first: gunzip",
        ),
        (b"BZh91AY", "f is compressed by bzip2"),
        (b"\xfd7zXZ\0", "f is compressed by xz"),
        (b"\x28\xb5\x2f\xfd\x04", "f is compressed by zstd"),
        (b"PK\x03\x04\x14", "f is a zip archive or a spreadsheet"),
        (b"MATLAB 5.0 MAT-file", "f is a MAT-file"),
        (b"\x89HDF\r\n", "f is an HDF5 file"),
        (b"\x7fELF\x02\x01\x01\0", "f is no text"),
        (
            b"1,2\r3,4\r",
            "f ends its lines with carriage returns alone",
        ),
        (
            b"<html>\n<body>\n</html>\n",
            "f, line 2, column 1 (<html>): '<body>' is not a number",
        ),
        (b"{\"x\": [1, 2]}\n{\"x\": [3, 4]}\n", "f, line 2, column 1"),
        (
            b"1,2\n--\n3,4\n",
            "f, line 2, column 2: the line has 1 columns",
        ),
        (
            b"1,2\n1 2\n",
            "f, line 2, column 2: the line has 2 columns, separated by spaces, the first has 1",
        ),
        (
            b"0x10,2\n3,4\n",
            "f, line 1, column 1: '0x10' is not a number",
        ),
        (
            b"12:30,2\n12:31,4\n",
            "f, line 1, column 1: '12:30' is not a number",
        ),
        (
            b"1_000,2\n3,4\n",
            "f, line 1, column 1: '1_000' is not a number",
        ),
        (
            wide.as_bytes(),
            "f, line 2, column 2: the line has 1 columns, separated by commas, the first has \
                1000000",
        ),
    ];
    assert!(bad.len() >= 40);
    for (bytes, expected) in bad {
        let error = from(bytes, &[], Some(0.5)).unwrap_err();
        let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(40)]);
        assert!(error.starts_with(expected), "{shown:?}: {error}");
    }
}

#[test]
fn a_line_without_end_is_refused_before_it_fills_the_memory() {
    let endless = BufReader::new(std::io::repeat(b'1'));
    let error = parse("f".into(), endless, &[], Some(1.0)).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("f, line 1: the line is longer than"),
        "{error}"
    );
}

fn read(text: &str, dt: Option<f64>) -> NumberTable {
    let table = parse("f".into(), text.as_bytes(), &[], dt);
    table.unwrap_or_else(|error| panic!("{text:?}: {error}"))
}

#[test]
fn headers_of_several_lines_and_units_are_read() {
    let labview = "LabVIEW Measurement\nWriter_Version\t2\nSeparator\tTab\n\n\
        ***End_of_Header***\nX_Value\tu\tComment\n0.0\t1.5\n0.5\t2.5\n1.0\t3.0\n";
    // As LabVIEW fills its lines with tabs.
    let filled = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\n\
        Channels\t1\t\nSamples\t3\t\nX0\t0.0E+0\t\nDelta_X\t0.5\t\n***End_of_Header***\t\t\n\
        X_Value\tu\tComment\n0.0\t1.5\t\n0.5\t2.5\t\n1.0\t3.0\t\n";
    for (text, names, values) in [
        (
            "t,x\ns,V\n0,0.1\n1,0.2\n2,0.4\n",
            vec!["x"],
            vec![0.1, 0.2, 0.4],
        ),
        (
            "run 7\n\nt;x\n[s];[V]\n0;1\n1;2\n2;5\n",
            vec!["x"],
            vec![1.0, 2.0, 5.0],
        ),
        (
            labview,
            vec!["X_Value", "u"],
            vec![0.0, 1.5, 0.5, 2.5, 1.0, 3.0],
        ),
        (
            filled,
            vec!["X_Value", "u"],
            vec![0.0, 1.5, 0.5, 2.5, 1.0, 3.0],
        ),
    ] {
        let table = read(text, Some(1.0).filter(|_| names.len() > 1));
        assert_eq!(
            (&table.names[..], &table.values),
            (
                &names[..].iter().map(|n| n.to_string()).collect::<Vec<_>>()[..],
                &values
            )
        );
        assert!(table.notes[0].contains("nothing else"), "{:?}", table.notes);
    }
    // A wrong number in the first row is no header.
    let wrong = parse("f".into(), "t,x\n0,O.1\n1,0.2\n".as_bytes(), &[], None);
    assert!(
        wrong
            .unwrap_err()
            .to_string()
            .contains("line 2, column 2 (x)")
    );
}

#[test]
fn a_column_whose_name_ends_in_time_is_the_time_where_no_better_one_is() {
    for name in [
        "Elapsed time",
        "elapsed_time (s)",
        "Time (s)",
        "time [ms]",
        "T",
    ] {
        let table = read(&format!("x,{name}\n0,0\n3,0.5\n1,1\n"), None);
        assert_eq!(
            (&*table.names, table.dt),
            (&["x".to_owned()][..], 0.5),
            "{name}"
        );
    }
    let table = read("reaction time,t\n3,0\n4,1\n1,2\n", None);
    assert_eq!(table.names, ["reaction time"]);
    // A name that only contains the word is no time.
    let other = parse("f".into(), "x,timeout\n0,0\n3,0.5\n".as_bytes(), &[], None);
    assert!(other.unwrap_err().to_string().contains("--dt is missing"));
}

#[test]
fn names_lose_their_quotes() {
    for text in [
        "\"t\", \"x, y\"\n0,1\n1,2\n",
        "'t';\"x, y\"\n0;1\n1;2\n",
        "\"t\"  \"x, y\"\n0 1\n1 2\n",
    ] {
        assert_eq!(read(text, None).names, ["x, y"], "{text:?}");
    }
}

#[test]
fn times_that_are_even_up_to_their_rounding_are_even() {
    let rounded = |step: f64, lost: usize, name: &str| {
        let rows = (0..40).filter(|k| *k != lost);
        let rows = rows.map(|k| format!("{:.3},{}\n", step * k as f64, k * k % 7));
        format!("{name},x\n") + &rows.collect::<String>()
    };
    let third = rounded(1.0 / 30.0, 40, "t");
    for dt in [None, Some(1.0 / 30.0), Some(0.0333)] {
        let table = read(&third, dt);
        assert_eq!(table.names, ["x"]);
        assert!((table.dt - 1.0 / 30.0).abs() < 1e-4, "{}", table.dt);
    }
    // By another name it is a coordinate, with a word.
    let other = read(&rounded(1.0 / 30.0, 40, "Zeit"), Some(1.0 / 30.0));
    assert_eq!(other.even_columns().next().unwrap().0, 0);
    // A lost row is a gap however the times are rounded.
    for dt in [None, Some(1.0 / 30.0)] {
        let lost = rounded(1.0 / 30.0, 20, "t");
        let refused = parse("f".into(), lost.as_bytes(), &[], dt).unwrap_err();
        assert!(
            refused.to_string().contains("the time goes from"),
            "{refused}"
        );
    }
}
