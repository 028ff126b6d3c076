//! The directory for the report of a command. No command overwrites the report of another one.

use std::fs;
use std::path::{Path, PathBuf};

use super::error::CliError;
use super::output::print_remark;

/// Files of a report, which contain its command and the names of its other files.
const REPORT_FILES: [&str; 2] = ["experiment.json", "index.html"];

/// The option for the directory.
#[derive(Debug, Clone, clap::Args)]
pub struct OutDirectory {
    /// Directory for recordings, figures and page. If it has the report of another command, that one moves to its
    /// subdirectory `earlier-1`, `earlier-2` and so on
    #[arg(long, default_value = "revprio-out", value_name = "DIRECTORY", value_hint = clap::ValueHint::DirPath)]
    out: PathBuf,
}

impl OutDirectory {
    /// Creates the directory for the report of `command`, and sets the report of another command aside.
    ///
    /// The report of the same command is replaced. Call it before the runs, so that an error is found early.
    pub fn create(&self, command: &str) -> Result<&Path, CliError> {
        make_directory(&self.out)?;
        let report = Report::in_directory(&self.out);
        if let Some(report) = report.filter(|report| !report.is_of(command)) {
            let earlier = report.set_aside(&self.out)?;
            print_remark(format_args!("the report of another command is now in {}", earlier.display()));
        }
        Ok(&self.out)
    }
}

/// Creates a directory.
pub fn make_directory(out: &Path) -> Result<(), CliError> {
    fs::create_dir_all(out).map_err(|source| CliError::Directory { path: out.to_owned(), source })
}

/// The texts of a report.
struct Report(Vec<String>);

impl Report {
    /// Reads the report in a directory, if there is one.
    fn in_directory(out: &Path) -> Option<Self> {
        let texts: Vec<String> =
            REPORT_FILES.iter().filter_map(|name| fs::read_to_string(out.join(name)).ok()).collect();
        (!texts.is_empty()).then_some(Self(texts))
    }

    /// Returns whether the report is that of this command.
    fn is_of(&self, command: &str) -> bool {
        let in_html = command.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
        let in_json = serde_json::to_string(command).unwrap_or_default();
        self.0.iter().any(|text| text.contains(&in_json) || text.contains(&format!(">{in_html}<")))
    }

    /// Returns whether the report names a file, the same figure or recording in another format, or shows a figure of this name.
    fn names(&self, file: &str) -> bool {
        let has_stem = |stem: &str| {
            let rest = file.strip_prefix(stem).filter(|_| !stem.is_empty());
            rest.is_some_and(|rest| rest.starts_with('.'))
        };
        self.0.iter().any(|text| {
            let mut quoted = text.split('"').filter_map(|name| name.rsplit_once('.'));
            let mut figures = text.split("<figure id=\"").skip(1).filter_map(|rest| rest.split('"').next());
            quoted.any(|(stem, _)| has_stem(stem)) || figures.any(has_stem)
        })
    }

    /// Moves the files of the report to a new subdirectory, and returns it. Files that the report does not name stay.
    fn set_aside(&self, out: &Path) -> Result<PathBuf, CliError> {
        set_aside(out, |name| REPORT_FILES.contains(&name) || self.names(name))
    }
}

/// Moves files, by their names, to a new subdirectory `earlier-1`, `earlier-2` and so on, and returns it.
pub fn set_aside(out: &Path, moves: impl Fn(&str) -> bool) -> Result<PathBuf, CliError> {
    let mut numbered = (1_u64..).map(|number| out.join(format!("earlier-{number}")));
    let earlier = numbered.find(|directory| !directory.exists()).unwrap_or_else(|| out.join("earlier"));
    let failed = |source| CliError::Directory { path: earlier.clone(), source };
    make_directory(&earlier)?;
    for entry in fs::read_dir(out).and_then(Iterator::collect::<Result<Vec<_>, _>>).map_err(failed)? {
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_file() && moves(&name) {
            fs::rename(entry.path(), earlier.join(&name)).map_err(failed)?;
        }
    }
    Ok(earlier)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_report_of_another_command_is_overwritten() {
        let out = std::env::temp_dir().join(format!("revprio-out-{}", std::process::id()));
        let option = OutDirectory { out: out.clone() };
        let (first, second) = (r#"revprio simulate "a" & b"#, r#"revprio simulate "a" & b --stateless"#);
        let write = |name: &str, text: &str| fs::write(out.join(name), text).unwrap();
        option.create(first).unwrap();
        write("experiment.json", &serde_json::json!({ "command": first, "trace": "a.csv" }).to_string());
        write("a.csv", "1");
        write("a.recording.json", "1");
        // Files of others, whose names are parts of words of the report.
        write("mine.toml", "2");
        write("e", "3");
        write("rev", "4");
        option.create(first).unwrap();
        assert!(out.join("a.csv").exists() && !out.join("earlier-1").exists());
        option.create(second).unwrap();
        assert!(out.join("earlier-1/a.csv").exists() && out.join("earlier-1/experiment.json").exists());
        assert!(out.join("earlier-1/a.recording.json").exists() && !out.join("a.csv").exists());
        assert!(["mine.toml", "e", "rev"].iter().all(|name| out.join(name).exists()));
        write("index.html", "<code>revprio simulate &quot;a&quot; &amp; b --stateless</code><figure id=\"b\">");
        write("b.svg", "1");
        option.create(second).unwrap();
        assert!(!out.join("earlier-2").exists());
        option.create("revprio compare a").unwrap();
        assert!(
            out.join("earlier-2/b.svg").exists()
                && out.join("earlier-2/index.html").exists()
                && out.join("earlier-1/a.csv").exists()
        );
        fs::remove_dir_all(out).unwrap();
    }
}
