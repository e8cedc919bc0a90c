//! Which commit and compiler made a report.

use std::process::Command;

use super::page::Origin;

impl Origin {
    /// Asks git about the project's folder and the compiler about itself; what does not answer stays unknown.
    pub(super) fn ask() -> Origin {
        let folder = env!("CARGO_MANIFEST_DIR");
        let git = |arguments: &[&str]| {
            let mut command = Command::new("git");
            first_line(command.arg("-C").arg(folder).args(arguments))
        };
        let commit = git(&["rev-parse", "HEAD"]).map(|commit| {
            // Tables and pictures of this very run may differ before they are committed; sources must not.
            match git(&[
                "status",
                "--porcelain",
                "--",
                "src",
                "crates",
                "data",
                "assets",
                "Cargo.toml",
                "Cargo.lock",
            ]) {
                None => commit,
                Some(_) => format!("{commit}, with uncommitted changes"),
            }
        });
        Origin {
            commit,
            compiler: first_line(Command::new("rustc").arg("--version")),
        }
    }
}

/// The first line that a command prints, if it succeeds and prints one.
fn first_line(command: &mut Command) -> Option<String> {
    let output = command
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    text.lines().next().map(str::to_owned)
}
