//! The Cargo examples run.

use revprio::service::{AppState, Robots, RunningServer, router};

#[path = "../../api/rust/examples/client.rs"]
#[expect(dead_code, reason = "its main function reads the arguments of the program")]
mod client;
#[path = "../../crates/core/examples/controller.rs"]
mod controller;
#[path = "../../crates/core/examples/library.rs"]
mod library;

#[test]
fn library_examples_run_without_a_server() {
    library::main().unwrap();
    controller::main().unwrap();
}

#[test]
fn client_example_calls_a_service() {
    let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
    client::run(&server.url()).unwrap();
    drop(server);
    let nobody = client::run("http://127.0.0.1:9").unwrap_err();
    assert!(nobody.to_string().contains("is the service running there?"), "{nobody}");
}
