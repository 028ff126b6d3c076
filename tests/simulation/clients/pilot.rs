//! A client that controls an arm: it measures, sends the state, and commands the arm as the guide demands.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use revprio_api::wire;
use tokio::time::Instant;

use crate::arm::Arm;
use crate::call::{Call, Open};
use crate::controllers::Design;
use crate::exchange::{Client, Fate, Link};
use crate::http::Answer;
use crate::random::Random;

/// Longest time from a measurement to its command for which the hold time is proved, as in `docs/limits.md`.
const MIN_SPARE_TIME: Duration = Duration::from_millis(10);

/// A client with its arm and its session.
pub struct Pilot {
    design: Design,
    arm: Arm,
    owner: Option<String>,
    key: Option<String>,
    /// ID of the session, if there is one.
    pub session: Option<String>,
    sequence: u64,
    /// Difference of the client's clock, s.
    clock: f64,
    /// Whether the arm must come to rest before it is commanded again: the service believes that it got another command.
    must_rest: bool,
    /// Whether all states of the session were measured, so that the arm must stay inside its range.
    is_honest: bool,
}

/// A measured state and its time.
#[derive(Debug, Clone)]
pub struct Measured {
    pub state: Arc<wire::State>,
    pub at: Instant,
}

impl Pilot {
    pub fn new(random: &mut Random) -> Self {
        let design = Design::random(random);
        let arm = Arm::at_rest(&design.robot, random);
        Self {
            arm,
            design,
            owner: random.one_in(2).then(|| random.word()),
            key: None,
            session: None,
            sequence: 0,
            clock: random.between(-10.0, 1e6),
            must_rest: false,
            is_honest: true,
        }
    }

    /// Opens a session, with the same key again if the answer was lost. Returns false if there is none.
    pub async fn open(&mut self, client: &mut Client, link: &mut Option<Link>) -> bool {
        self.key = client.random.one_in(2).then(|| client.random.word());
        for attempt in 0..4 {
            let call = Call::Open(self.opening(self.owner.clone()));
            let fate = match client.random.below(12) {
                0 if attempt == 0 => Fate::DiesSending,
                1 if attempt == 0 => Fate::DiesWaiting,
                _ => Fate::Undisturbed,
            };
            let answer = client.exchange(link, vec![call], fate).await.pop().flatten();
            if let Some(answer) = answer.filter(|answer| answer.status == 201) {
                let created: wire::CreatedController = answer.read().unwrap();
                self.session = Some(created.id);
                (self.sequence, self.must_rest, self.is_honest) = (client.random.from(0, 1000), true, true);
                return true;
            }
            client.pause(1, 40).await;
        }
        false
    }

    /// Repeats the request that opened the session, sometimes with another owner. The oracle knows what must happen.
    pub async fn open_again(&self, client: &mut Client, link: &mut Option<Link>) {
        let owner = if client.random.one_in(3) { Some(client.random.word()) } else { self.owner.clone() };
        client.call(link, Call::Open(self.opening(owner))).await;
    }

    fn opening(&self, owner: Option<String>) -> Open {
        Open { design: self.design.clone(), owner, key: self.key.clone() }
    }

    /// Measures the arm and returns the next state.
    pub async fn measure(&mut self, client: &mut Client) -> Measured {
        self.arm.advance();
        while self.must_rest && self.design.keeps_positions() && !self.arm.is_at_rest() {
            tokio::time::sleep(Duration::from_millis(20)).await;
            self.arm.advance();
        }
        self.must_rest = false;
        self.check_range(client);
        let random = &mut client.random;
        self.sequence += if random.one_in(20) { random.from(2, 10_000) } else { 1 };
        // A clock that jumps must not matter.
        if random.one_in(25) {
            self.clock += random.between(-1e3, 1e3);
        }
        let state = wire::State {
            channels: BTreeMap::new(),
            wrenches: BTreeMap::new(),
            obstacles: Vec::new(),
            sequence: self.sequence,
            time_s: self.clock + client.world.time_s(),
            joint_position: self.arm.position().into(),
            joint_velocity: random.one_in(2).then(|| self.arm.velocity().into()),
            wrench: (self.design.needs_wrench() || random.one_in(2)).then(|| wrench(random, 20.0)),
            targets: BTreeMap::new(),
        };
        Measured { state: Arc::new(state), at: Instant::now() }
    }

    /// Demands that the arm is inside its range, if it got every command of the session and no other.
    fn check_range(&mut self, client: &Client) {
        let session = self.session.as_deref().unwrap_or_default();
        self.is_honest &= client.world.oracle().is_used_by_one(session);
        if let Some(outside) = self.arm.outside().filter(|_| self.is_honest && self.design.keeps_positions()) {
            panic!("{}: the arm left its range: {outside}", client.name);
        }
    }

    /// Returns the call that sends a state.
    pub fn step(&self, state: &Arc<wire::State>) -> Call {
        let session = self.session.clone().unwrap_or_default();
        Call::Step { session, owner: self.owner.clone(), state: Arc::clone(state), fault: None }
    }

    pub fn owner(&self) -> Option<String> {
        self.owner.clone()
    }

    /// Handles the answer to a measured state.
    pub fn settle(&mut self, client: &Client, measured: &Measured, answer: &Answer) {
        match answer.status {
            200 => self.apply(measured, &answer.read().unwrap()),
            404 => self.forget(),
            409 => self.catch_up(client),
            _ => self.miss(),
        }
    }

    /// Commands the arm, unless the answer is too late.
    pub fn apply(&mut self, measured: &Measured, answer: &wire::StepAnswer) {
        let latency = measured.at.elapsed();
        let spare = Duration::from_secs_f64(self.design.wire.period_s).max(MIN_SPARE_TIME);
        if latency <= spare && latency <= Duration::from_millis(answer.valid_for_ms) {
            self.arm.apply(answer, measured.at);
        } else {
            self.miss();
        }
    }

    /// Continues with the sequence numbers of another client of the session.
    pub fn catch_up(&mut self, client: &Client) {
        self.miss();
        let last = client.world.oracle().last_state(self.session.as_deref().unwrap_or_default());
        self.sequence = self.sequence.max(last.map_or(0, |state| state.sequence));
    }

    /// Notes that the service may have computed a command that the arm did not get.
    pub fn miss(&mut self) {
        self.must_rest = true;
    }

    /// Notes that the session has ended.
    pub fn forget(&mut self) {
        self.session = None;
        self.must_rest = true;
    }

    /// Returns a state that the service must refuse: it is not plausible, or it is too old.
    pub fn refused_state(&mut self, random: &mut Random, last: &wire::State) -> wire::State {
        let mut state = last.clone();
        state.sequence += 1;
        let n = self.design.robot.joint_count();
        let scale = random.pick(&[2e9, 1e9, 200.0]);
        match random.below(5) {
            0 => state.joint_position = vec![0.0; n + 1].into(),
            1 => state.joint_velocity = Some(vec![0.0; n - 1].into()),
            2 => state.sequence = 1 << 53,
            3 => {
                state.sequence = last.sequence - last.sequence.min(random.from(0, 3));
                state.time_s += 0.5;
            }
            // Some of these are accepted, if the controller has no bound.
            _ => state.wrench = Some(wrench(random, scale)),
        }
        state
    }

    /// Returns a plausible state that nobody measured. The arm then no longer has to stay inside its range.
    pub fn wild_state(&mut self, random: &mut Random) -> Arc<wire::State> {
        self.is_honest = false;
        self.must_rest = true;
        self.sequence += random.pick(&[1, 1, 5, 1_000_000]);
        Arc::new(wild_state(&self.design, self.sequence, random))
    }
}

/// Returns a plausible state at random.
pub fn wild_state(design: &Design, sequence: u64, random: &mut Random) -> wire::State {
    let joints = design.robot.joints();
    let place =
        |joint: &revprio_robot::Joint| random.between(joint.limits.lower.max(-6.0), joint.limits.upper.min(6.0));
    let position: Vec<f64> = joints.iter().map(place).collect();
    let velocity: Vec<f64> = joints.iter().map(|_| random.between(-5.0, 5.0)).collect();
    wire::State {
        channels: BTreeMap::new(),
        wrenches: BTreeMap::new(),
        obstacles: Vec::new(),
        sequence,
        time_s: random.between(-1e9, 1e9),
        joint_position: position.into(),
        joint_velocity: random.one_in(2).then(|| velocity.into()),
        wrench: Some(wrench(random, 90.0)),
        targets: BTreeMap::new(),
    }
}

fn wrench(random: &mut Random, max: f64) -> wire::Wrench {
    let mut three = || std::array::from_fn(|_| random.between(-1.0, 1.0) * max);
    wire::Wrench { force: three(), torque: three() }
}
