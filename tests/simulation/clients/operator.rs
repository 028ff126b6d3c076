//! Whoever runs the service: it is stopped, killed and started again, and its machine pauses.

use std::time::Duration;

use tokio::io::AsyncWriteExt as _;

use crate::call::{Call, Format};
use crate::exchange::{Client, Link};
use crate::world::Phase;

pub async fn run(client: &mut Client) {
    for _ in 0..client.random.from(1, 3) {
        client.pause(5, 150).await;
        match client.random.below(7) {
            0 | 1 => pause_machine(client).await,
            2 => burst(client).await,
            3 | 4 => kill(client).await,
            _ => drain(client).await,
        }
    }
}

/// The machine stands still for a while: no task runs, but time passes.
async fn pause_machine(client: &mut Client) {
    client.world.oracle().has_paused = true;
    let pause = client.random.millis(5, 400);
    client.note(&format!("the machine pauses for {pause:?}"));
    tokio::time::advance(pause).await;
}

/// The machine pauses in the middle of many requests. Those after the pause have waited too long.
async fn burst(client: &mut Client) {
    if client.world.plan.config.max_connections < 100 {
        return;
    }
    client.world.oracle().has_paused = true;
    let mut links: Vec<Link> = (0..20).filter_map(|_| client.connect_through(1 << 16)).collect();
    tokio::time::sleep(Duration::from_millis(1)).await;
    let half = links.len() / 2;
    for link in &links[..half] {
        write(client, link).await;
    }
    // This task runs after those that read the requests before it.
    let pause = tokio::spawn(tokio::time::advance(Duration::from_millis(50)));
    for link in &links[half..] {
        write(client, link).await;
    }
    pause.await.expect("a pause does not fail");
    for link in &mut links {
        let answer = link.answer().await;
        let text = answer.as_ref().map(|answer| format!("{} {}", answer.status, answer.problem()));
        client.note(&format!("← {}", text.as_deref().unwrap_or("nothing")));
        assert!(answer.is_some() || !link.instance.is_serving(), "the service does not answer");
        assert!(answer.is_none_or(|answer| answer.status == 200 || answer.problem() == "overloaded"));
    }
}

async fn write(client: &Client, link: &Link) {
    let request = client.request(&Call::List, Format::Json);
    // The network holds the whole request, so this does not wait.
    let _ = link.wire().write_all(&request.bytes()).await;
}

async fn kill(client: &mut Client) {
    let instance = client.world.instance();
    client.note(&format!("kills service {}", instance.number));
    instance.kill();
    if client.random.one_in(2) {
        client.pause(0, 50).await;
    }
    client.world.replace();
}

/// Stops the service while another one starts, before or after its end.
async fn drain(client: &mut Client) {
    let instance = client.world.instance();
    client.note(&format!("stops service {}", instance.number));
    let mut link = client.connect();
    instance.stop();
    let is_replaced_first = client.random.one_in(2);
    if is_replaced_first {
        client.world.replace();
    }
    tokio::time::sleep(Duration::from_millis(5)).await;
    if client.world.plan.config.drain_delay > Duration::from_millis(20) {
        let answer = client.call(&mut link, Call::Ready).await;
        assert!(answer.is_none_or(|answer| answer.status == 503), "a service that ends is ready");
    }
    let config = &client.world.plan.config;
    let longest = config.drain_delay + config.drain_timeout + Duration::from_millis(100);
    let ended = tokio::time::timeout(longest, instance.ended()).await;
    assert!(ended.is_ok(), "the service does not end: {:?}", instance.phase());
    assert!(matches!(instance.phase(), Phase::Ended(_)));
    client.note(&format!("service {} has ended", instance.number));
    if !is_replaced_first {
        client.pause(0, 30).await;
        client.world.replace();
    }
}
