//! The clients of a run.

mod intruder;
mod nuisance;
mod operator;
mod pilot;
mod requests;
mod stateless;
mod stream;

use crate::exchange::Client;
use crate::plan::Role;

/// Runs a client to its end.
pub async fn run(mut client: Client, role: Role) {
    match role {
        Role::Loop => requests::run(&mut client).await,
        Role::Stream => stream::run(&mut client).await,
        Role::Intruder => intruder::run(&mut client).await,
        Role::Nuisance => nuisance::run(&mut client).await,
        Role::Stateless => stateless::run(&mut client).await,
        Role::Operator => operator::run(&mut client).await,
    }
}
