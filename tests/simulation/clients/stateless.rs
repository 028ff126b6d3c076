//! A client whose controller needs no session: the memory travels with the requests.

use std::sync::Arc;

use revprio_api::wire;

use super::pilot::wild_state;
use crate::call::Call;
use crate::controllers::Design;
use crate::exchange::Client;
use crate::random::Random;

pub async fn run(client: &mut Client) {
    client.pause(0, 50).await;
    // Several clients have the same controllers, so that the service finds them in its cache.
    let seed = client.random.from(0, 3);
    let design = Design::random(&mut Random::new(seed));
    let (mut link, mut memory, mut sequence) = (None, None, client.random.from(0, 100));
    let mut reference = crate::reference::Reference::new(&design);
    for _ in 0..client.random.from(2, 8) {
        sequence += 1;
        let state = wild_state(&design, sequence, &mut client.random);
        let request = wire::StepRequest { controller: (*design.wire).clone(), state, memory: memory.clone() };
        let call = Call::Once { request: Arc::new(request) };
        let answer = client.call(&mut link, call.clone()).await;
        let Some(answer) = answer.filter(|answer| answer.status == 200) else { continue };
        let Call::Once { request } = call else { continue };
        let mut answer: wire::StepAnswer = answer.read().unwrap();
        if let Err(difference) = reference.compare(&request.state, &answer) {
            panic!("{}: {difference}", client.name);
        }
        memory = answer.memory.take();
        client.pause(0, 10).await;
    }
}
