//! The name of a scenario, which becomes a part of the names of files.

use super::field_error::FieldError;

/// Largest number of characters of a name.
const MAX_LEN: usize = 80;

/// Characters that a path or a shell gives a meaning to.
const FORBIDDEN: &str = "/\\:*?\"<>|";

/// Characters with which a name must not begin: hidden files and options begin with them.
const NOT_FIRST: &str = " .-";

/// Checks the name of a scenario.
pub fn check_name(name: &str, pointer: &str) -> Result<(), FieldError> {
    let is_allowed = |character: char| !character.is_control() && !FORBIDDEN.contains(character);
    let is_len = (1..=MAX_LEN).contains(&name.chars().count());
    if is_len && !name.starts_with(|first| NOT_FIRST.contains(first)) && name.chars().all(is_allowed) {
        return Ok(());
    }
    let problem = format!(
        "becomes a part of file names: give 1 to {MAX_LEN} characters without control characters and without any of \
         / \\ : * ? \" < > |, and do not begin with a space, a dot or a hyphen"
    );
    Err(FieldError::new(pointer, problem))
}

/// Returns the regular expression of names, for the OpenAPI document.
#[must_use]
pub fn name_pattern() -> String {
    let forbidden = format!(r"\u0000-\u001f\u007f-\u009f{}", FORBIDDEN.replace('\\', r"\\"));
    format!("^[^{forbidden}{NOT_FIRST}][^{forbidden}]{{0,{}}}$", MAX_LEN - 1)
}

#[cfg(test)]
mod tests {
    use super::super::scenario::BUILT_IN_SCENARIOS;
    use super::*;

    #[test]
    fn names_that_leave_the_directory_are_refused() {
        for name in ["../../evil", "/tmp/evil", "a/b", "a\\b", "", "..", ".hidden", "-o", " a", "a\nb", "a:b", "a\"b"] {
            assert!(check_name(name, "/name").is_err(), "{name}");
        }
        assert!(check_name(&"a".repeat(MAX_LEN), "/name").is_ok());
        let error = check_name(&"a".repeat(MAX_LEN + 1), "/name").unwrap_err();
        assert!(error.to_string().starts_with("`name` becomes a part of file names: give 1 to 80 characters"));
    }

    #[test]
    fn other_names_are_allowed() {
        let others = ["Prüfstand 3", "v1.2", "a..b", "walls (soft), 10%", "壁", "_x", "ends."];
        for name in BUILT_IN_SCENARIOS.into_iter().map(|(name, _)| name).chain(others) {
            assert_eq!(check_name(name, "/name"), Ok(()), "{name}");
        }
    }

    #[test]
    fn the_pattern_names_the_same_characters() {
        let pattern = r#"^[^\u0000-\u001f\u007f-\u009f/\\:*?"<>| .-][^\u0000-\u001f\u007f-\u009f/\\:*?"<>|]{0,79}$"#;
        assert_eq!(name_pattern(), pattern);
    }
}
