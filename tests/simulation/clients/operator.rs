//! Whoever runs the service: it is stopped, killed and started again, and its machine pauses.

use std::time::Duration;

use crate::call::Call;
use crate::exchange::Client;
use crate::world::Phase;

pub async fn run(client: &mut Client) {
    for _ in 0..client.random.from(1, 3) {
        client.pause(5, 150).await;
        match client.random.below(3) {
            0 => pause_machine(client).await,
            1 => kill(client).await,
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
    if tokio::time::timeout(longest, instance.ended()).await.is_err() {
        panic!("the service does not end: {:?}", instance.phase());
    }
    assert!(matches!(instance.phase(), Phase::Ended(_)));
    client.note(&format!("service {} has ended", instance.number));
    if !is_replaced_first {
        client.pause(0, 30).await;
        client.world.replace();
    }
}
