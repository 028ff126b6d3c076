//! Runs the commands of a page like a reader: in a clone, in order, against the server that the page starts.

use std::io::{BufRead, BufReader};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::page::root;

/// Address of the server on the pages.
const PRINTED_ADDRESS: &str = "127.0.0.1:8080";

/// Replacement for Cargo, because the program is already built.
const CARGO: &str = r#"#!/bin/sh
[ "$1 $2 $3" = 'run --release --' ] && shift 3 && exec revprio "$@"
echo "only 'cargo run --release -- …' is run in tests" >&2
exit 1
"#;

/// A directory with the contents of the repository, and the last server that was started.
pub struct Shell {
    directory: PathBuf,
    server: Option<Child>,
    address: String,
}

impl Shell {
    /// `name` must be unique to the page.
    pub fn new(name: &str) -> Self {
        let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("docs").join(name);
        let _ = std::fs::remove_dir_all(&directory);
        let programs = directory.join("target/programs");
        std::fs::create_dir_all(&programs).unwrap();
        symlink(env!("CARGO_BIN_EXE_revprio"), programs.join("revprio")).unwrap();
        std::fs::write(programs.join("cargo"), CARGO).unwrap();
        std::fs::set_permissions(programs.join("cargo"), PermissionsExt::from_mode(0o755)).unwrap();
        for entry in std::fs::read_dir(root()).unwrap().map(Result::unwrap) {
            let name = entry.file_name();
            if name != "target" && name != "revprio-out" && !name.to_string_lossy().starts_with('.') {
                symlink(entry.path(), directory.join(name)).unwrap();
            }
        }
        Self { directory, server: None, address: PRINTED_ADDRESS.to_owned() }
    }

    /// Runs commands. Returns standard output, or standard output and standard error of a failure.
    pub fn run(&self, commands: &str) -> Result<String, String> {
        if self.server.is_none() && commands.contains(PRINTED_ADDRESS) {
            return Err("the page has not started a server".to_owned());
        }
        let commands = commands.replace(PRINTED_ADDRESS, &self.address);
        let output =
            self.command("timeout").args(["300", "bash", "-euo", "pipefail", "-c", &commands]).output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).replace(&self.address, PRINTED_ADDRESS);
        if output.status.success() { Ok(text) } else { Err(text + &String::from_utf8_lossy(&output.stderr)) }
    }

    /// Starts the server for the following commands, on a free port.
    pub fn serve(&mut self, command: &str) -> Result<(), String> {
        self.stop();
        let command = format!("exec {} --listen 127.0.0.1:0", command.trim());
        let mut server = self.command("bash");
        server.args(["-c", &command]).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut server = server.spawn().unwrap();
        let mut line = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut line).unwrap();
        self.server = Some(server);
        let address = line.trim().strip_prefix("listening on http://");
        address.ok_or("the server does not listen")?.clone_into(&mut self.address);
        Ok(())
    }

    fn command(&self, program: &str) -> Command {
        let programs = self.directory.join("target/programs");
        let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
        let mut command = Command::new(program);
        command.current_dir(&self.directory).env("PATH", path);
        command
    }

    fn stop(&mut self) {
        if let Some(mut server) = self.server.take() {
            let _ = server.kill();
            let _ = server.wait();
        }
    }
}

impl Drop for Shell {
    fn drop(&mut self) {
        self.stop();
        let _ = std::fs::remove_dir_all(&self.directory);
    }
}
