//! `revprio openapi` and `revprio asyncapi`

use crate::program::success;

#[test]
fn printed_interface_documents_equal_the_committed_ones() {
    for (command, committed) in
        [("openapi", include_str!("../../api/openapi.json")), ("asyncapi", include_str!("../../api/asyncapi.json"))]
    {
        assert!(success(&[command]) == committed, "cargo run -- {command} > api/{command}.json");
    }
}
