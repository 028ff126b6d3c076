//! `revprio openapi` and `revprio asyncapi`

use crate::program::success;

#[test]
fn the_interface_descriptions_are_printed_as_they_are_committed() {
    for (command, committed) in
        [("openapi", include_str!("../../api/openapi.json")), ("asyncapi", include_str!("../../api/asyncapi.json"))]
    {
        assert!(success(&[command]) == committed, "cargo run -- {command} > api/{command}.json");
    }
}
