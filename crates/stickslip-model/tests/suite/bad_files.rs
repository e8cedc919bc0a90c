//! Files with one error each: the message, its location in the file, and the advice.

use stickslip_model::file::{FileError, Problem, Source, SystemFile};

use crate::run::parsed;

/// A valid file. Each case changes one place of it.
const GOOD: &str = r#"name = "test"
description = "a block"
[time]
unit = "s"
start = 0
end = 20
period = "2*pi/w"
[states]
x = "m"
v = { unit = "m/s", meaning = "velocity" }
[parameters]
mu0 = 0.4
delta = { value = 3, unit = "s/m", range = [0, inf] }
vp = "1/5"
w = 1.5
[definitions]
slip = "belt*(v - vp)"
drive = "sin(w*t)"
[contacts.belt]
boundary = "v - vp"
friction = "mu0/(1 + delta*slip)"
static = "2*mu0"
[field]
x = "v"
v = "drive - x - friction(belt)"
[start]
x = 0.5
v = "vp/2"
[section]
function = "x"
direction = "rising"
[ranges]
x = [-2, 2]
"#;

/// A case of `bad_files.txt` or `bad_jumps.txt`: the text replaced and its replacement; the
/// message, the part of the file that it marks, and the advice.
type Case = [String; 5];

fn cases(table: &str) -> Vec<Case> {
    let cells = |line: &str| -> Vec<String> {
        line.split('~')
            .map(|cell| cell.replace("\\n", "\n"))
            .collect()
    };
    table
        .lines()
        .map(|line| cells(line).try_into().unwrap())
        .collect()
}

fn problem_of(text: &str) -> (Problem, String) {
    let source = Source {
        name: "test.toml".to_owned(),
        text: text.to_owned(),
    };
    match SystemFile::parse(source) {
        Ok(_) => panic!("it was understood:\n{text}"),
        Err(FileError::Wrong {
            problem,
            source_text,
        }) => {
            let shown = problem.shown(&source_text);
            (*problem, shown)
        }
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn the_good_files_are_good() {
    parsed(GOOD);
    parsed(JUMPS);
}

#[test]
fn each_bad_file_is_reported_what_is_wrong_where_and_what_to_do() {
    let (files, jumps) = (
        cases(include_str!("bad_files.txt")),
        cases(include_str!("bad_jumps.txt")),
    );
    assert_eq!((files.len(), jumps.len()), (75, 72));
    let all = files.iter().map(|case| (GOOD, case));
    let mut wrong = Vec::new();
    for (good, case) in all.chain(jumps.iter().map(|case| (JUMPS, case))) {
        assert!(
            good.contains(&case[0]),
            "`{}` is not in the good file",
            case[0]
        );
        if let Err(why) = check_case(good, case) {
            wrong.push(format!("{} -> {}: {why}", case[0], case[1]));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

/// Whether a case is reported as expected.
fn check_case(good: &str, [from, to, message, token, help]: &Case) -> Result<(), String> {
    let text = good.replacen(from, to, 1);
    let (problem, shown) = problem_of(&text);
    let require = |good: bool, what: &str| {
        if good {
            Ok(())
        } else {
            Err(format!("{what}:\n{shown}"))
        }
    };
    require(problem.message.contains(message), message)?;
    let place = &text[problem.place.clone()];
    // For a table its heading is enough.
    let is_table = token.is_empty() || token.starts_with('[');
    require(
        place == token || is_table && place.starts_with(token),
        token,
    )?;
    require(
        problem.help.as_deref().unwrap_or_default().contains(help),
        help,
    )?;
    // Line and column, and the line itself.
    let before = &text[..problem.place.start];
    let line = before.matches('\n').count();
    let begin = before.rfind('\n').map_or(0, |end| end + 1);
    let at = format!(
        "test.toml:{}:{}",
        line + 1,
        before[begin..].chars().count() + 1
    );
    require(shown.contains(&at), &at)?;
    let source = text.lines().nth(line).unwrap_or_default();
    require(shown.contains(source), source)
}

#[test]
fn what_needs_several_contacts_or_sides_is_reported() {
    let two = GOOD
        .replace(
            "v = \"drive - x - friction(belt)\"",
            "v = { below = \"1\", above = \"-friction(belt)\" }",
        )
        .replace("[field]", "[contacts.wall]\nboundary = \"x\"\n[field]");
    let (problem, _) = problem_of(&two);
    assert!(
        problem
            .message
            .contains("with 2 contacts it is not clear whose sides")
    );
    let stop = "[stops.floor]\ngap = \"x\"\nacts = { v = 1 }\nrestitution = 0\n[field]";
    let force = GOOD
        .replace("static = \"2*mu0\"", "normal_force = \"1 - x\"")
        .replace("mu0/(1 + delta*slip)", "load/(1 + delta*slip)")
        .replace("drive = \"sin", "load = \"mu0*floor.force\"\ndrive = \"sin")
        .replace("[field]", stop);
    let (problem, shown) = problem_of(&force);
    let message = "the friction of contact `belt` follows a reaction";
    assert!(problem.message.contains(message), "{shown}");
    assert!(shown.contains("leave `normal_force` out"), "{shown}");
}

/// In a restitution, `approach` is the speed of approach, so no other name of the file.
#[test]
fn a_parameter_called_approach_is_refused_in_a_restitution() {
    let own = "name = \"drop\"\nstates = { h = \"\", w = \"\" }\nparameters = { approach = 0.5 }\n\
               field = { h = \"w\", w = \"-1\" }\nstart = { h = 0.02, w = 0 }\n[stops.floor]\n\
               gap = \"h\"\nacts = { w = 1 }\nrestitution = \"approach\"\n";
    let (problem, shown) = problem_of(own);
    let message = "`approach` is a parameter and the speed of approach";
    assert!(problem.message.contains(message), "{shown}");
    assert!(shown.contains("choose another name"), "{shown}");
}

#[test]
fn more_states_or_contacts_than_the_solver_has_room_for_are_reported() {
    let contacts: String = (0..16)
        .map(|k| format!("[contacts.c{k}]\nboundary = \"x\"\n"))
        .collect();
    let states: String = (0..63).map(|k| format!("s{k} = \"m\"\n")).collect();
    for (from, to, message, limit) in [
        (
            "[field]",
            format!("{contacts}[field]"),
            "contact number 17",
            "16 contacts",
        ),
        (
            "x = \"m\"\n",
            format!("x = \"m\"\n{states}"),
            "state number 65",
            "64 states",
        ),
    ] {
        let (problem, _) = problem_of(&GOOD.replacen(from, &to, 1));
        assert!(problem.message.contains(message), "{}", problem.message);
        let help = problem.help.unwrap_or_default();
        assert!(help.contains(limit), "{help}");
    }
}

#[test]
fn places_are_right_in_every_kind_of_quotes() {
    for (quoted, token) in [
        ("'v - vq'", "vq"),
        ("\"\"\"\n  v - vq\"\"\"", "vq"),
        ("'''v - vq'''", "vq"),
        // With escapes the columns do not match the bytes, and the whole string is marked.
        (r#""v - v\u0071""#, r#""v - v\u0071""#),
    ] {
        let text = GOOD.replacen("boundary = \"v - vp\"", &format!("boundary = {quoted}"), 1);
        let (problem, shown) = problem_of(&text);
        assert_eq!(&text[problem.place.clone()], token, "{shown}");
    }
}

#[test]
fn nesting_without_end_is_refused() {
    let deep = format!("{}x{}", "(".repeat(5000), ")".repeat(5000));
    let (problem, _) = problem_of(&GOOD.replacen("sin(w*t)", &deep, 1));
    assert!(problem.message.contains("nested deeper than 100 levels"));
}

#[test]
fn greek_names_and_the_micro_sign_are_the_same_letter() {
    let text = GOOD
        .replacen("mu0 = 0.4", "\"\u{b5}₀\" = 0.4", 1)
        .replace("mu0/(1", "μ₀/(1")
        .replace("2*mu0", "2·\u{b5}₀");
    let file = parsed(&text);
    assert_eq!(file.parameters[0].name, "μ₀");
    assert!(file.with(&[("\u{b5}₀".to_owned(), 0.3)]).is_ok());
}

/// An é as one byte, as in Latin-1, in the second line.
#[test]
fn a_file_in_another_code_is_reported_with_its_line() {
    let text = GOOD.replace("a block", "a bloc l\u{e9}ger");
    let bytes: Vec<u8> = text.chars().map(|letter| letter as u8).collect();
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    let path = file.path().to_str().unwrap();
    let error = SystemFile::open(path).unwrap_err();
    assert!(
        matches!(error, FileError::NotUtf8 { line: 2, .. }),
        "{error}"
    );
    assert!(error.to_string().ends_with("save it as UTF-8"), "{error}");
    std::fs::write(file.path(), text).unwrap();
    assert!(SystemFile::open(path).is_ok());
}

/// A valid file with jumps and inputs. Each case changes one place of it.
const JUMPS: &str = r#"name = "test"
[states]
x = "m"
v = "m/s"
[discrete]
n = 0
[parameters]
r = 0.8
w = 2
[inputs.push]
shape = "pulse"
period = "2*pi/w"
width = 0.1
[inputs.force]
shape = "table"
times = [0, 1, 2]
values = [0, 1, 0]
[switches.drive]
function = "sin(w*t)"
[field]
x = "v"
v = "-x + push + force + drive"
[jumps.wall]
when = "x - 1"
direction = "rising"
set = { v = "-r*v", n = "n + 1" }
"#;

#[test]
fn a_table_whose_file_is_wrong_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("system.toml");
    let text = JUMPS.replace(
        "times = [0, 1, 2]\nvalues = [0, 1, 0]",
        "file = \"force.csv\"",
    );
    std::fs::write(&path, text).unwrap();
    let report = || {
        SystemFile::open(path.to_str().unwrap())
            .unwrap_err()
            .to_string()
    };
    let absent = report();
    assert!(
        absent.contains("cannot read") && absent.contains("begins in the folder of this file"),
        "{absent}"
    );
    for (content, message) in [
        ("t,f\n0,0\n1\n", "line 3 has no value"),
        ("t,f\n0,0\n,1\n", "line 3 has no time"),
        (
            "t,f\n0,0\n1,much\n",
            "line 3 has `much`, which is no finite number",
        ),
        (
            "t,f\n0,0\n1,NaN\n",
            "line 3 has `NaN`, which is no finite number",
        ),
        ("0,0\n1,2\n1,3\n1,4\n", "not in order: 1 comes before 1"),
        ("t,f\n", "a table of 0 points"),
        ("t,f\n0,0\n", "a table of 1 points"),
    ] {
        std::fs::write(folder.path().join("force.csv"), content).unwrap();
        assert!(report().contains(message), "{}", report());
    }
    std::fs::write(folder.path().join("force.csv"), "t,f\n0,0\n1,2\n").unwrap();
    assert!(SystemFile::open(path.to_str().unwrap()).is_ok());
}

#[test]
fn a_boundary_that_does_not_move_is_reported() {
    for boundary in ["drive", "n", "push*n"] {
        let text = JUMPS.replace("drive\"\n[jumps", "drive - friction(c)\"\n[jumps");
        let contact = format!("[contacts.c]\nboundary = \"{boundary}\"\nfriction = \"1\"\n[jumps");
        let (problem, shown) = problem_of(&text.replacen("[jumps", &contact, 1));
        assert!(
            problem
                .message
                .contains("the boundary of contact `c` depends on no state that moves"),
            "{shown}"
        );
    }
    for (from, to) in [("x - 1", "c*(x - 1)"), ("-r*v", "-r*v*c")] {
        let contact = "[contacts.c]\nboundary = \"v\"\nfriction = \"1\"\n[jumps";
        let text = JUMPS.replace("drive\"\n[jumps", "drive - friction(c)\"\n[jumps");
        let text = text.replacen("[jumps", contact, 1).replacen(from, to, 1);
        let (problem, shown) = problem_of(&text);
        assert!(
            problem
                .message
                .contains("a jump cannot depend on the side of a contact"),
            "{shown}"
        );
    }
}
