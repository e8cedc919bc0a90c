//! Files with one error each: the message, its location in the file, and the advice.

use stickslip_kernels::file::{FileError, SystemFile};
use stickslip_kernels::file::{Problem, Source};

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

/// The text replaced and its replacement; the message, the part of the file that it marks, and the
/// advice.
type Case = (
    &'static str,
    &'static str,
    &'static str,
    &'static str,
    &'static str,
);

const CASES: [Case; 69] = [
    // The file itself.
    (
        "name = \"test\"\n",
        "",
        "the file has no `name`",
        "",
        "what the system is called",
    ),
    (
        "[time]",
        "[tiem]",
        "the file has no entry `tiem`",
        "tiem",
        "did you mean `time`?",
    ),
    (
        "[time]",
        "[qqq]",
        "the file has no entry `qqq`",
        "qqq",
        "there can be `name`",
    ),
    (
        "name = \"test\"",
        "name = 3",
        "a text in quotes is expected here, not a number",
        "3",
        "",
    ),
    (
        "name = \"test\"",
        "name = test",
        "",
        "test",
        "the file must be TOML",
    ),
    (
        "mu0 = 0.4",
        "mu0 = 0.4\nmu0 = 0.5",
        "the parameter `mu0` stands twice in [parameters]",
        "mu0",
        "remove one of the two",
    ),
    (
        "x = \"m\"\n",
        "x = \"m\"\nx = \"mm\"\n",
        "the state `x` stands twice in [states]",
        "x",
        "remove one of the two",
    ),
    (
        "[start]\n",
        "[start]\nv = 0\n",
        "the state `v` stands twice in [start]",
        "v",
        "remove one of the two",
    ),
    (
        "meaning = \"velocity\"",
        "unit = \"m\"",
        "the entry `unit` stands twice in [states]",
        "unit",
        "remove one of the two",
    ),
    (
        "w = 1.5",
        "w = 0",
        "this is infinite where `2*pi` is 6.28318530718 and `w` is 0",
        "2*pi/w",
        "a parameter",
    ),
    (
        "description = \"a block\"",
        "name = \"a block\"",
        "the entry `name` stands twice in the head of the file",
        "name",
        "remove one of the two",
    ),
    (
        "[ranges]",
        "[states]",
        "the table [states] stands twice in the file",
        "states",
        "below one header",
    ),
    ("mu0 = 0.4", "μ0 = 0.4", "", "μ", "in quotes: \"μ0\""),
    ("[states]", "[states", "", "", "the file must be TOML"),
    // Time.
    (
        "end = 20",
        "end = -1",
        "the end -1 does not lie after the start 0",
        "-1",
        "",
    ),
    (
        "end = 20",
        "end = \"3*x\"",
        "the end of a run cannot depend on `x`, which is a state",
        "x",
        "",
    ),
    (
        "end = 20",
        "end = \"-w\"",
        "the end -1.5 does not lie after the start 0",
        "\"-w\"",
        "",
    ),
    (
        "end = 20",
        "end = nan",
        "a finite number is expected here, not NaN",
        "nan",
        "",
    ),
    (
        "end = 20",
        "stop = 20",
        "[time] has no entry `stop`",
        "stop",
        "there can be `unit`",
    ),
    (
        "\"2*pi/w\"",
        "\"-2*pi/w\"",
        "the period is -4.18879020479, but must be positive",
        "\"-2*pi/w\"",
        "",
    ),
    (
        "\"2*pi/w\"",
        "\"2*pi/x\"",
        "a period cannot depend on `x`, which is a state",
        "x",
        "numbers and parameters",
    ),
    (
        "\"2*pi/w\"",
        "\"t\"",
        "a period cannot depend on `t`, which is time",
        "t",
        "",
    ),
    // States.
    (
        "[states]\nx = \"m\"\nv = { unit = \"m/s\", meaning = \"velocity\" }",
        "[states]",
        "[states] is empty",
        "",
        "x = \"m\"",
    ),
    (
        "[states]",
        "[stats]",
        "the file has no entry `stats`",
        "stats",
        "did you mean `states`?",
    ),
    (
        "meaning = \"velocity\"",
        "start = 3",
        "[states.v] has no entry `start`",
        "start",
        "there can be `unit`, `meaning`",
    ),
    (
        "x = \"m\"",
        "x = 5",
        "a text in quotes is expected here, not a number",
        "5",
        "",
    ),
    (
        "x = \"m\"\n",
        "x = \"m\"\n\"2x\" = \"m\"\n",
        "`2x` cannot be a name",
        "\"2x\"",
        "letters, digits",
    ),
    (
        "x = \"m\"\n",
        "x = \"m\"\n\"a b\" = \"m\"\n",
        "`a b` cannot be a name",
        "\"a b\"",
        "letters, digits",
    ),
    (
        "x = \"m\"\n",
        "x = \"m\"\nsin = \"m\"\n",
        "`sin` is a function already",
        "sin",
        "another name",
    ),
    (
        "x = \"m\"\n",
        "x = \"m\"\nt = \"m\"\n",
        "`t` is the name of time already",
        "t",
        "another name",
    ),
    // Parameters.
    (
        "w = 1.5",
        "x = 1.5",
        "`x` is the name of a state already",
        "x",
        "all names are together",
    ),
    (
        "mu0 = 0.4",
        "mu0 = nan",
        "a finite number is expected here, not NaN",
        "nan",
        "",
    ),
    (
        "mu0 = 0.4",
        "mu0 = true",
        "an expression in quotes, or a number, is expected here, not true or false",
        "true",
        "",
    ),
    (
        "vp = \"1/5\"",
        "vp = \"1/0\"",
        "this is infinite",
        "1/0",
        "change the expression",
    ),
    (
        "vp = \"1/5\"",
        "vp = \"sqrt(-2)\"",
        "this is not a number",
        "sqrt(-2)",
        "change the expression",
    ),
    (
        "vp = \"1/5\"",
        "vp = \"mu0/2\"",
        "unknown name `mu0`",
        "mu0",
        "goes into [definitions]",
    ),
    (
        "value = 3",
        "value = -3",
        "delta = -3 lies outside its range from 0 to inf",
        "-3",
        "",
    ),
    ("[0, inf]", "[0]", "has two numbers, this has 1", "[0]", ""),
    (
        "[0, inf]",
        "[5, 1]",
        "the range from 5 to 1 is empty",
        "[5, 1]",
        "lower end comes first",
    ),
    (
        "[0, inf]",
        "[0, nan]",
        "a finite number is expected here",
        "nan",
        "",
    ),
    (
        "value = 3, ",
        "",
        "[parameters.delta] has no `value`",
        "{ unit = \"s/m\", range = [0, inf] }",
        "it is needed",
    ),
    // Expressions.
    (
        "drive - x",
        "drive - xx",
        "unknown name `xx`",
        "xx",
        "did you mean `x`?",
    ),
    (
        "mu0/(1",
        "mu_0/(1",
        "unknown name `mu_0`",
        "mu_0",
        "did you mean `mu0`?",
    ),
    (
        "mu0/(1",
        "2 mu0/(1",
        "the name `mu0` is not expected here",
        "mu0",
        "2*x",
    ),
    (
        "sin(w*t)",
        "sin w*t",
        "the name `w` is not expected here",
        "w",
        "a product needs its sign",
    ),
    (
        "sin(w*t)",
        "sinus(w*t)",
        "unknown function `sinus`",
        "sinus",
        "did you mean `sin`?",
    ),
    (
        "sin(w*t)",
        "log(w)",
        "unknown function `log`",
        "log",
        "the natural logarithm is ln",
    ),
    (
        "sin(w*t)",
        "pow(w, 2)",
        "unknown function `pow`",
        "pow",
        "x^2",
    ),
    (
        "sin(w*t)",
        "sin(w, t)",
        "sin takes one argument, not 2",
        "sin(w, t)",
        "",
    ),
    (
        "sin(w*t)",
        "max(w)",
        "max takes two or more arguments, not 1",
        "max(w)",
        "",
    ),
    (
        "sin(w*t)",
        "w(t)",
        "`w` is a parameter, not a function",
        "w",
        "w*(…)",
    ),
    (
        "sin(w*t)",
        "sin(w*t",
        "this bracket is not closed",
        "(",
        "it ends with `)`",
    ),
    (
        "sin(w*t)",
        "sin(w*t))",
        "`)` is not expected here",
        ")",
        "no bracket is open",
    ),
    ("sin(w*t)", "w**2", "`**` is no operator", "**", "x^2"),
    (
        "sin(w*t)",
        "|x|",
        "`|` does not belong into an expression",
        "|",
        "abs(…)",
    ),
    (
        "sin(w*t)",
        "ln(w - 1.5)",
        "this is infinite",
        "ln(w - 1.5)",
        "",
    ),
    (
        "sin(w*t)",
        "sgn(x)",
        "unknown function `sgn`",
        "sgn",
        "the sign of its side",
    ),
    ("sin(w*t)", "", "there is no expression here", "", ""),
    (
        "sin(w*t)",
        "drive + 1",
        "the definition of `drive` depends on itself",
        "\"drive + 1\"",
        "",
    ),
    // Contacts.
    (
        "boundary = \"v - vp\"\n",
        "",
        "[contacts.belt] has no `boundary`",
        "[contacts.belt]",
        "zero where the contact can stick",
    ),
    (
        "boundary = \"v - vp\"",
        "boundary = \"t - 1\"",
        "the boundary of contact `belt` depends on no state",
        "\"t - 1\"",
        "v - vp",
    ),
    (
        "boundary = \"v - vp\"",
        "boundary = \"slip\"",
        "a boundary cannot depend on the side of a contact",
        "belt",
        "sides belong into [field]",
    ),
    (
        "friction = \"mu0/(1 + delta*slip)\"\n",
        "",
        "has static friction but no friction in slip",
        "\"2*mu0\"",
        "friction(belt)",
    ),
    (
        "friction(belt)",
        "friction(best)",
        "`best` is no contact",
        "best",
        "did you mean `belt`?",
    ),
    (
        "friction(belt)",
        "0.4*belt",
        "the friction of contact `belt` is not used in [field]",
        "belt",
        "friction(belt)",
    ),
    (
        "[contacts.belt]",
        "[contacts.other]\nboundary = \"x\"\n[contacts.belt]",
        "the field is the same on both sides of contact `other`",
        "other",
        "by_side(other",
    ),
    // Field, start, section, ranges.
    (
        "v = \"drive - x - friction(belt)\"\n",
        "",
        "[field] has no rate of the state `v`",
        "[field]",
        "its derivative by time",
    ),
    (
        "x = 0.5\n",
        "",
        "[start] has no value of the state `x`",
        "[start]",
        "x = 0",
    ),
    (
        "direction = \"rising\"",
        "direction = \"up\"",
        "there is no direction `up`",
        "\"up\"",
        "`rising`",
    ),
];

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
fn the_good_file_is_good() {
    let source = Source {
        name: "test.toml".to_owned(),
        text: GOOD.to_owned(),
    };
    SystemFile::parse(source).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn each_bad_file_is_reported_what_is_wrong_where_and_what_to_do() {
    let mut wrong = Vec::new();
    for case in CASES {
        let places = GOOD.matches(case.0).count();
        assert!(places > 0, "`{}` is not in the good file", case.0);
        if let Err(why) = check_case(case) {
            wrong.push(format!("{} -> {}: {why}", case.0, case.1));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

/// Whether a case is reported as expected.
fn check_case((from, to, message, token, help): Case) -> Result<(), String> {
    let text = GOOD.replacen(from, to, 1);
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
    let force = GOOD
        .replace("static = \"2*mu0\"", "normal_force = \"1 - x\"")
        .replace("[field]", "[contacts.wall]\nboundary = \"x\"\n[field]");
    let (problem, _) = problem_of(&force);
    assert!(problem.message.contains("with one contact only"));
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
    let source = Source {
        name: "test.toml".to_owned(),
        text,
    };
    let file = SystemFile::parse(source).unwrap_or_else(|error| panic!("{error}"));
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
fn what_is_wrong_with_jumps_and_inputs_is_reported_where_it_is() {
    assert!(
        SystemFile::parse(Source {
            name: String::new(),
            text: JUMPS.to_owned()
        })
        .is_ok()
    );
    let cases: [Case; 72] = [
        (
            "\"2*pi/w\"",
            "-1",
            "the period is -1, but must be positive",
            "-1",
            "",
        ),
        (
            "\"2*pi/w\"",
            "\"1 + t\"",
            "the period of an input cannot depend on time",
            "\"1 + t\"",
            "a switch",
        ),
        (
            "set = { v",
            "set = { vv",
            "there is no state `vv`",
            "vv",
            "did you mean `v`?",
        ),
        (
            "\"x - 1\"",
            "\"r - 1\"",
            "`when` of the jump `wall` is constant",
            "\"r - 1\"",
            "a function of states",
        ),
        (
            "when = \"x - 1\"\n",
            "",
            "[jumps.wall] has no `when`",
            "",
            "whose zero it is",
        ),
        (
            "\"rising\"",
            "\"up\"",
            "there is no direction `up`",
            "\"up\"",
            "`rising`, `falling`, `both`",
        ),
        (
            "set = { v = \"-r*v\", n = \"n + 1\" }\n",
            "",
            "the jump `wall` sets no state",
            "",
            "stop = true",
        ),
        (
            "set = {",
            "reset = {",
            "[jumps.wall] has no entry `reset`",
            "reset",
            "`set`",
        ),
        (
            "direction = \"rising\"",
            "stop = 1",
            "true or false is expected",
            "1",
            "",
        ),
        (
            "direction = \"rising\"",
            "count = 0",
            "a whole number from 1 on",
            "0",
            "",
        ),
        (
            "direction = \"rising\"",
            "count = 2.5",
            "a whole number from 1 on",
            "2.5",
            "",
        ),
        (
            "direction = \"rising\"",
            "count = 2\nstop = true",
            "`stop` and `count` say the same",
            "2",
            "count = 1",
        ),
        ("\"n + 1\"", "\"n + q\"", "unknown name `q`", "q", ""),
        (
            "\"n + 1\"",
            "\"n + wall\"",
            "`wall` is a jump and has no value",
            "wall",
            "discrete state",
        ),
        ("n = 0", "n = \"x\"", "cannot depend on `x`", "x", ""),
        (
            "n = 0",
            "x = 0",
            "`x` is the name of a state already",
            "x",
            "choose another",
        ),
        (
            "n = 0",
            "n = true",
            "an expression in quotes, or a number,",
            "true",
            "",
        ),
        (
            "[jumps.wall]",
            "[jumps.drive]",
            "`drive` is the name of a jump already",
            "",
            "choose another",
        ),
        (
            "\"pulse\"",
            "\"puls\"",
            "there is no shape `puls`",
            "\"puls\"",
            "did you mean `pulse`?",
        ),
        (
            "width = 0.1",
            "width = 1.5",
            "the width 1.5 is not between 0 and 1",
            "1.5",
            "part of the period",
        ),
        (
            "width = 0.1\n",
            "",
            "[inputs.push] has no `width`",
            "",
            "part of the period",
        ),
        (
            "period = \"2*pi/w\"\nwidth",
            "width",
            "[inputs.push] has no `period`",
            "",
            "period =",
        ),
        (
            "\"2*pi/w\"",
            "\"x\"",
            "the period of an input cannot depend on a state",
            "\"x\"",
            "an expression of parameters",
        ),
        (
            "width = 0.1",
            "width = 0.1\nduty = 2",
            "[inputs.push] has no entry `duty`",
            "duty",
            "there can be",
        ),
        (
            "[0, 1, 2]",
            "[0, 2, 1]",
            "the times are not in order: 2 comes before 1",
            "[0, 2, 1]",
            "are a step",
        ),
        (
            "[0, 1, 2]",
            "[0, 1]",
            "2 times and 3 values",
            "[0, 1]",
            "each time has its value",
        ),
        (
            "[0, 1, 2]",
            "[0, 1, nan]",
            "a finite number is expected",
            "nan",
            "",
        ),
        (
            "[0, 1, 2]",
            "[0, 1, \"2\"]",
            "a number is expected",
            "\"2\"",
            "",
        ),
        (
            "times = [0, 1, 2]\n",
            "",
            "a table has times and values, or a file",
            "",
            "force.csv",
        ),
        (
            "values = [0, 1, 0]",
            "values = [0, 1, 0]\nbetween = \"cubic\"",
            "cannot be `cubic`",
            "\"cubic\"",
            "linear or constant",
        ),
        (
            "\"sin(w*t)\"",
            "\"sin(x)\"",
            "the function of the switch `drive` depends on a state",
            "\"sin(x)\"",
            "a contact",
        ),
        (
            "\"sin(w*t)\"",
            "\"w\"",
            "the function of the switch `drive` does not depend on time",
            "\"w\"",
            "a parameter",
        ),
        (
            "\"x - 1\"",
            "\"x - x\"",
            "`when` of the jump `wall` is constant",
            "\"x - x\"",
            "a function of states",
        ),
        (
            "\"x - 1\"",
            "1",
            "`when` of the jump `wall` is constant",
            "1",
            "a function of states",
        ),
        ("\"x - 1\"", "\"\"", "there is no expression here", "", ""),
        (
            "\"x - 1\"",
            "\"wall\"",
            "`wall` is a jump and has no value",
            "wall",
            "discrete state",
        ),
        (
            "\"-r*v\"",
            "\"ln(r - 1)*v\"",
            "this is not a number",
            "ln(r - 1)",
            "a parameter",
        ),
        (
            "\"-r*v\"",
            "\"1/0\"",
            "this is infinite",
            "1/0",
            "a parameter",
        ),
        (
            "[field]\n",
            "[field]\nn = \"1\"\n",
            "`n` is a discrete state and stands in [discrete] alone",
            "n",
            "by jumps only",
        ),
        (
            "[field]\n",
            "[start]\nx = 0\nv = 0\nn = 2\n[field]\n",
            "`n` is a discrete state and stands in [discrete] alone",
            "n",
            "has its start",
        ),
        ("n = 0", "n = \"1/0\"", "this is infinite", "1/0", ""),
        (
            "n = 0",
            "n = nan",
            "a finite number is expected here, not NaN",
            "nan",
            "",
        ),
        (
            "n = 0",
            "n = { value = 1 }",
            "an expression in quotes, or a number,",
            "{ value = 1 }",
            "",
        ),
        (
            "n = 0",
            "n = 0\nw = 1",
            "`w` is the name of a parameter already",
            "w",
            "choose another",
        ),
        (
            "n = 0",
            "\"n-1\" = 0",
            "`n-1` cannot be a name",
            "\"n-1\"",
            "letters, digits",
        ),
        (
            "[0, 1, 2]\nvalues = [0, 1, 0]",
            "[1]\nvalues = [2]",
            "a table of 1 points in time",
            "[1]",
            "two at least",
        ),
        (
            "[0, 1, 2]",
            "3",
            "a list of numbers is expected here, not a number",
            "3",
            "",
        ),
        (
            "[0, 1, 2]",
            "[0, 1, inf]",
            "a finite number is expected here, not inf",
            "inf",
            "",
        ),
        (
            "values = [0, 1, 0]",
            "values = [0, 1, 0]\nfile = \"a.csv\"",
            "a table has times and values, or a file",
            "",
            "force.csv",
        ),
        (
            "width = 0.1",
            "width = 0",
            "the width 0 is not between 0 and 1",
            "0",
            "part of the period",
        ),
        (
            "width = 0.1",
            "width = \"w\"",
            "the width 2 is not between 0 and 1",
            "\"w\"",
            "part of the period",
        ),
        (
            "width = 0.1",
            "width = 0.1\nbetween = \"constant\"",
            "[inputs.push] has no entry `between`",
            "between",
            "`width`",
        ),
        (
            "shape = \"pulse\"\n",
            "",
            "[inputs.push] has no `shape`",
            "",
            "or table",
        ),
        (
            "\"2*pi/w\"",
            "0",
            "the period is 0, but must be positive",
            "0",
            "comes again",
        ),
        (
            "\"2*pi/w\"",
            "\"drive\"",
            "the period of an input cannot depend on a state or another input",
            "\"drive\"",
            "parameters",
        ),
        (
            "\"2*pi/w\"",
            "\"2*pi/w\"\nphase = \"x\"",
            "the phase of an input cannot depend on a state",
            "\"x\"",
            "parameters",
        ),
        (
            "\"2*pi/w\"",
            "\"2*pi/w\"\nphase = \"t\"",
            "the phase of an input cannot depend on time",
            "\"t\"",
            "a switch",
        ),
        ("\"2*pi/w\"", "\"1/0\"", "this is infinite", "1/0", ""),
        (
            "\"sin(w*t)\"",
            "\"push - 0.5\"",
            "the function of the switch `drive` depends on a state or another input",
            "\"push - 0.5\"",
            "a function of time",
        ),
        (
            "\"sin(w*t)\"",
            "\"n - 0.5\"",
            "the function of the switch `drive` depends on a state",
            "\"n - 0.5\"",
            "sets a discrete state",
        ),
        (
            "\"sin(w*t)\"",
            "\"0*t\"",
            "the function of the switch `drive` does not depend on time",
            "\"0*t\"",
            "sin(w*t)",
        ),
        (
            "\"sin(w*t)\"",
            "\"sin(w*t)\"\nperiod = 3",
            "[switches.drive] has no entry `period`",
            "period",
            "`function`",
        ),
        (
            "[switches.drive]\nfunction = \"sin(w*t)\"",
            "[switches]\ndrive = \"sin(w*t)\"",
            "a table [switches.drive] is expected here",
            "\"sin(w*t)\"",
            "write a line [switches.drive]",
        ),
        (
            "[jumps.wall]",
            "[jumps.t]",
            "`t` is the name of time already",
            "t",
            "choose another",
        ),
        (
            "[jumps.wall]",
            "[jumps.sin]",
            "`sin` is a function already",
            "sin",
            "choose another",
        ),
        (
            "[inputs.push]",
            "[inputs.r]",
            "`r` is the name of a parameter already",
            "r",
            "choose another",
        ),
        (
            "{ v = \"-r*v\", n = \"n + 1\" }",
            "\"v\"",
            "a table [jumps.wall.set] is expected here",
            "\"v\"",
            "",
        ),
        (
            "{ v = \"-r*v\", n = \"n + 1\" }",
            "{ v = \"v\" }",
            "the jump `wall` sets every state to what it is",
            "",
            "stop = true",
        ),
        (
            "{ v = \"-r*v\", n = \"n + 1\" }",
            "{ r = \"0\" }",
            "`r` is a parameter, not a state",
            "r",
            "`x`, `v`, `n`",
        ),
        (
            "{ v = \"-r*v\", n = \"n + 1\" }",
            "{ t = \"0\" }",
            "`t` is time, not a state",
            "t",
            "`x`, `v`, `n`",
        ),
        (
            "direction = \"rising\"",
            "count = -1",
            "a whole number from 1 on is expected here, not -1",
            "-1",
            "",
        ),
        (
            "[jumps.wall]\nwhen",
            "[jumps]\nwhen",
            "a table [jumps.when] is expected here",
            "\"x - 1\"",
            "write a line [jumps.when]",
        ),
    ];
    for (from, to, message, part, help) in cases {
        let text = JUMPS.replacen(from, to, 1);
        assert_ne!(text, JUMPS, "{from}");
        let (problem, shown) = problem_of(&text);
        assert!(problem.message.contains(message), "{from} -> {to}: {shown}");
        if !part.is_empty() {
            assert_eq!(&text[problem.place.clone()], part, "{shown}");
        }
        let reported = problem.help.unwrap_or_default();
        assert!(reported.contains(help), "{from} -> {to}: {reported}");
    }
}

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
