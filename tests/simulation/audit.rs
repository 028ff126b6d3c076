//! The end of a run: the service that is left must agree with what the clients know, and then end without a rest.

use std::ops::RangeInclusive;
use std::time::Duration;

use revprio_api::wire;

use crate::call::Call;
use crate::exchange::Client;
use crate::http::Answer;

/// Longer than work may wait for a thread.
const CALM: Duration = Duration::from_secs(1);

/// Checks the service after all clients have ended.
pub async fn audit(client: &mut Client) {
    tokio::time::sleep(CALM).await;
    let instance = client.world.instance();
    let mut link = None;
    let known = client.world.oracle().known(instance.number);
    let mut call = async |call: Call| {
        let answer = client.call(&mut link, call.clone()).await;
        answer.unwrap_or_else(|| panic!("a service that does nothing else has no answer to {}", call.text()))
    };
    let list: wire::SessionList = call(Call::List).await.read().unwrap();
    for session in known {
        call(Call::Show { session }).await;
    }
    let metrics = call(Call::Other { method: "GET", path: "/metrics", host: "localhost", status: 200 }).await;
    // A session may end of idleness meanwhile.
    let rest: wire::SessionList = call(Call::List).await.read().unwrap();
    let checked = client.world.oracle().check_list(&list, instance.number);
    checked.unwrap_or_else(|violation| panic!("{violation}"));
    check_metrics(&metrics, rest.controllers.len()..=list.controllers.len());
    drop(link);
    end(client).await;
}

/// No connection, no session and no fault is left that nobody knows.
fn check_metrics(metrics: &Answer, sessions: RangeInclusive<usize>) {
    let text = String::from_utf8_lossy(&metrics.body);
    let value = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
        line.unwrap_or_else(|| panic!("no {name} in {text}")).to_owned()
    };
    let counted = value("revprio_sessions");
    assert!(counted.parse().is_ok_and(|counted| sessions.contains(&counted)), "{counted} sessions, not {sessions:?}");
    assert_eq!(value("revprio_connections"), "1", "connections leak");
    assert_eq!(value("revprio_panics_total"), "0");
    assert!(!text.contains(r#"revprio_problems_total{type="internal"}"#), "{text}");
}

/// Stops the service. It must end at once, because no client is left, and no task may stay.
async fn end(client: &mut Client) {
    let instance = client.world.instance();
    instance.stop();
    let longest = client.world.plan.config.drain_delay + Duration::from_millis(50);
    let ended = tokio::time::timeout(longest, instance.ended()).await;
    assert!(ended.is_ok(), "the service waits for a client that is gone");
    tokio::time::sleep(CALM).await;
    let tasks = tokio::runtime::Handle::current().metrics().num_alive_tasks();
    assert_eq!(tasks, 0, "tasks of a service that has ended still run");
}
