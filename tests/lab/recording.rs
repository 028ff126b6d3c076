//! Recordings are read as they were written, to the last bit.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use revprio::service::{AppState, Robots, RunningServer, router};
use revprio_api::Client;
use revprio_api::wire;
use revprio_lab::simulator::recording::{AtLimit, Format, Recording, Sensed, Surfaces, TableLayout, read};
use revprio_lab::simulator::{CallMode, Scenario, run};

/// A directory that is removed when dropped.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, format: Format) -> PathBuf {
        self.0.join(format!("run.{}", format.ending()))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Runs the given number of periods.
fn recorded(periods: u32) -> Recording {
    let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
    let mut scenario = Scenario::find("stiff_wall_singular").unwrap();
    scenario.duration_s = f64::from(periods) * 1e-3;
    run(&scenario, &Client::new(&server.url()), CallMode::Session, |_| ControlFlow::Continue(())).unwrap()
}

/// Returns the recording without real times.
fn without_timings(recording: &Recording) -> Recording {
    Recording { wall_time_s: 0.0, timings: Vec::new(), ..recording.clone() }
}

/// Formats all samples so that −0 and 0 differ, unlike with `==`.
fn bits(recording: &Recording) -> Vec<String> {
    recording.samples.iter().map(|sample| format!("{sample:?}")).collect()
}

#[test]
fn every_format_gives_the_same_recording() {
    let (scratch, recording) = (Scratch::new("recording"), recorded(600));
    assert_eq!(recording.timings.len(), 600);
    for format in Format::ALL {
        let file = scratch.file(format);
        format.write_file(&recording, false, &file).unwrap();
        let back = read(&file).unwrap();
        assert_eq!(back, without_timings(&recording), "{format:?}");
        assert_eq!(bits(&back), bits(&recording), "{format:?}");
        format.write_file(&recording, true, &file).unwrap();
        assert_eq!(read(&file).unwrap(), recording, "{format:?} with real times");
    }
}

#[test]
fn same_run_gives_the_same_bytes() {
    let scratch = Scratch::new("recording_bytes");
    let (first, mut second) = (recorded(50), recorded(50));
    // Real times differ from run to run.
    second.wall_time_s += 1.0;
    for format in Format::ALL {
        let bytes = [&first, &second].map(|recording| {
            format.write_file(recording, false, &scratch.file(format)).unwrap();
            std::fs::read(scratch.file(format)).unwrap()
        });
        assert!(bytes[0] == bytes[1], "{format:?}");
    }
}

/// Any finite number, with many special values.
fn number() -> impl Strategy<Value = f64> {
    let special = vec![0.0, -0.0, f64::MAX, f64::MIN_POSITIVE, 5e-324, -2.225_073_858_507_201e-308, 0.1, 1.0 / 3.0];
    prop_oneof![prop::sample::select(special), prop::num::f64::NORMAL, prop::num::f64::SUBNORMAL]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn any_numbers_and_words_are_read_as_written(
        numbers in prop::collection::vec(number(), 64),
        missing: [bool; 4],
        age in 0_u64..=i64::MAX as u64,
        limit in prop::sample::select(vec![AtLimit::Free, AtLimit::Lower, AtLimit::Upper, AtLimit::Below, AtLimit::Above]),
        is_sensed: bool,
    ) {
        let scratch = Scratch::new("recording_any");
        let mut recording = without_timings(&template());
        let mut next = numbers.iter().copied().cycle();
        let mut fill = |slots: &mut [f64]| slots.iter_mut().for_each(|slot| *slot = next.next().unwrap());
        for sample in &mut recording.samples {
            fill(&mut sample.joint_position);
            fill(&mut sample.joint_velocity);
            fill(&mut sample.actual_velocity);
            fill(&mut sample.orientation);
            fill(&mut sample.residual_norms);
            for vector in [&mut sample.position, &mut sample.force, &mut sample.torque, &mut sample.external_force] {
                fill(vector);
            }
            let mut optional = [0.0; 3];
            fill(&mut optional);
            sample.target_force = [0, 1, 2].map(|i| (!missing[i]).then_some(optional[i]));
            sample.wall_distance = (!missing[3]).then_some(optional[0]);
            sample.kkt_residual = missing[3].then_some(optional[1]);
            sample.least_distance = is_sensed.then_some(optional[2]);
            sample.limits.fill(limit);
            sample.answer_age = age;
            sample.answered = missing[0];
            sample.path = wire::Path::ActiveSet;
            sample.status = wire::Status::NotCertified;
            sample.sensed = is_sensed.then(|| Box::new(Sensed {
                joint_position: sample.joint_velocity.clone(),
                joint_velocity: sample.joint_position.clone(),
                force: optional,
                torque: sample.force,
            }));
        }
        for format in Format::ALL {
            format.write_file(&recording, false, &scratch.file(format)).unwrap();
            let back = read(&scratch.file(format)).unwrap();
            prop_assert_eq!(bits(&back), bits(&recording), "{:?}", format);
            prop_assert_eq!(&back, &recording, "{:?}", format);
        }
    }
}

/// Two periods of a run, to be overwritten.
fn template() -> Recording {
    static RUN: std::sync::OnceLock<Recording> = std::sync::OnceLock::new();
    RUN.get_or_init(|| recorded(2)).clone()
}

#[test]
fn errors_name_files_columns_and_values_that_are_not_valid() {
    let (scratch, recording) = (Scratch::new("recording_refused"), template());
    let refusal = |path: &Path| read(path).unwrap_err().to_string();
    assert!(refusal(&scratch.0.join("run.xlsx")).contains(".csv, .jsonl, .parquet, .mcap"));
    for format in Format::ALL {
        let file = scratch.file(format);
        format.write_file(&recording, false, &file).unwrap();
        let whole = std::fs::read(&file).unwrap();
        std::fs::write(&file, &whole[..whole.len() - 40]).unwrap();
        assert!(read(&file).is_err(), "{format:?}");
        std::fs::write(&file, b"nothing of the kind").unwrap();
        assert!(read(&file).is_err(), "{format:?}");
    }
    let csv = scratch.file(Format::Csv);
    Format::Csv.write_file(&recording, false, &csv).unwrap();
    let text = std::fs::read_to_string(&csv).unwrap();
    std::fs::write(&csv, text.replacen("force_x_n", "force_w_n", 1)).unwrap();
    assert!(refusal(&csv).contains("no column `force_x_n`"), "{}", refusal(&csv));
    std::fs::write(&csv, text.replacen("closed_form", "open_form", 1)).unwrap();
    assert!(refusal(&csv).contains("column `path`"), "{}", refusal(&csv));
    std::fs::remove_file(scratch.0.join("run.recording.json")).unwrap();
    assert!(refusal(&csv).contains("run.recording.json"), "{}", refusal(&csv));
}

#[test]
fn documentation_lists_every_column() {
    let text = include_str!("../../docs/recordings.md");
    let joints = ["JOINT".to_owned()];
    let all = TableLayout {
        watched: true,
        channels: 0,
        contacts: 1,
        surfaces: 1,
        joints: &joints,
        tasks: 1,
        sensed: true,
        timed: true,
    };
    let missing: Vec<String> = all
        .columns()
        .iter()
        .map(|column| format!("| `{}` | {} |", column.name, column.quantity.about))
        .filter(|line| !text.contains(line.as_str()))
        .collect();
    assert!(missing.is_empty(), "docs/recordings.md lacks\n{}", missing.join("\n"));
}

#[test]
fn the_commands_of_channels_are_recorded_in_every_format() {
    let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
    let mut scenario = Scenario::find("stiff_wall").unwrap();
    scenario.duration_s = 0.1;
    let target =
        serde_json::from_str(r#"{"kind": "ramp", "start": 0, "end": 1, "start_time_s": 0, "duration_s": 0.05}"#);
    scenario.controller.channels = vec![wire::Channel {
        name: "gripper".to_owned(),
        kind: wire::ChannelKind::Position,
        lower: 0.0,
        upper: 0.08,
        max_rate: 1.0,
        target: Some(target.unwrap()),
    }];
    let recording =
        run(&scenario, &Client::new(&server.url()), CallMode::Session, |_| ControlFlow::Continue(())).unwrap();
    let commands: Vec<f64> = recording.samples.iter().map(|sample| sample.channels[0].unwrap()).collect();
    assert!(commands.windows(2).all(|pair| (0.0..=1e-3 + 1e-12).contains(&(pair[1] - pair[0]))), "{commands:?}");
    assert_eq!(commands.last(), Some(&0.08));
    let scratch = Scratch::new("channels");
    for format in Format::ALL {
        let file = scratch.file(format);
        format.write_file(&recording, false, &file).unwrap();
        let back = read(&file).unwrap();
        assert!(
            back.samples.iter().map(|sample| &sample.channels).eq(recording.samples.iter().map(|s| &s.channels)),
            "{format:?}"
        );
    }
}

#[test]
fn the_normal_of_a_surface_is_recorded_in_every_format() {
    let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
    let mut scenario = Scenario::find("wiping").unwrap();
    scenario.duration_s = 4.0;
    let recording =
        run(&scenario, &Client::new(&server.url()), CallMode::Session, |_| ControlFlow::Continue(())).unwrap();
    let surfaces = |recording: &Recording| -> Vec<Surfaces> {
        recording.samples.iter().map(|sample| sample.contacts.surface.clone()).collect()
    };
    let [first, last] = [0, recording.samples.len() - 1].map(|i| &recording.samples[i].contacts.surface);
    // The stated axis until the tool slides, and then the normal of the plane, into it, and its friction.
    let [x, _, z] = first.normal[0].map(Option::unwrap);
    assert!(
        x.abs() < 1e-12 && (z + 1.0).abs() < 1e-12 && first.friction == [None] && first.normal_uncertainty == [None]
    );
    let outward = scenario.contacts[0].normal.unwrap();
    let cosine: f64 = (0..3).map(|i| -outward[i] * last.normal[0][i].unwrap()).sum();
    assert!(cosine > 1.0_f64.to_radians().cos(), "{cosine}");
    assert!((last.friction[0].unwrap() - 0.3).abs() < 0.03 && last.normal_uncertainty[0].unwrap() < 0.1, "{last:?}");
    let scratch = Scratch::new("surfaces");
    for format in Format::ALL {
        let file = scratch.file(format);
        format.write_file(&recording, false, &file).unwrap();
        assert!(surfaces(&read(&file).unwrap()) == surfaces(&recording), "{format:?}");
    }
}
