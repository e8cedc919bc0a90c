//! Largest numbers of states and contacts of a file.

use stickslip_model::file::{SettingError, Source, System, SystemFile};

/// A system with a given number of states, each stopped by a contact.
fn system(states: usize, contacts: usize) -> Result<System, SettingError> {
    let each =
        |count: usize, line: &dyn Fn(usize) -> String| -> String { (0..count).map(line).collect() };
    let text = format!(
        "name = \"many\"\n[parameters]\nk = 1\nunused = 1\n[states]\n{}[field]\n{}{}",
        each(states, &|i| format!("x{i} = \"\"\n")),
        each(states, &|i| match i {
            0 => format!(
                "x0 = \"-k*x0{}\"\n",
                each(contacts, &|j| format!(" - friction(c{j})"))
            ),
            _ => format!("x{i} = \"-x{i}\"\n"),
        }),
        each(contacts, &|j| format!(
            "[contacts.c{j}]\nboundary = \"x0 - {j}\"\nfriction = \"1\"\n"
        ))
    );
    let name = "many.toml".to_owned();
    SystemFile::parse(Source { name, text })?.with(&[])
}

#[test]
fn as_many_states_as_a_file_can_have_leave_room_for_a_parameter() {
    let most = system(64, 1).unwrap();
    assert_eq!(most.dynamics().states(), 64);
    assert_eq!(most.with_states_of(&[0]).unwrap().states(), 65);
    assert_eq!(most.with_states_of(&[1, 0]).unwrap().states(), 66);
}

#[test]
fn more_contacts_than_states_are_told() {
    let error = system(1, 2).err().unwrap().to_string();
    assert!(
        error.contains("2 contacts are too many for 1 state"),
        "{error}"
    );
}
