//! Programs next to the controller that stream targets, as an application would.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use nalgebra::Vector3;
use revprio_api::wire::{self, Axis};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::field_error::{FieldError, number, positive};

/// Largest number of programs of a scenario.
const MAX_STREAMS: usize = 100;

/// A program that streams the target of a task in each period. It knows the place of the tool and the last answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum TargetProgram {
    /// A force along the motion of the tool, as for a door or a drawer whose direction is not known.
    ForceAlongMotion {
        /// Name of a task with the law `force` and the axes x, y and z of the base.
        #[schema(example = "pull")]
        task: String,
        /// Force F_d, N.
        #[schema(example = 15.0)]
        force: f64,
        /// Direction of the force at the start, base axes; of any length except zero.
        #[schema(example = json!([1.0, 0.0, 0.0]))]
        start_direction: [f64; 3],
        /// Way of the tool after which a direction of its motion is forgotten to 1/e, m.
        #[schema(example = 0.005)]
        memory_m: f64,
    },
    /// A spiral of Archimedes, as for a peg whose hole is not where it should be. The tool moves along it while the first axis with the
    /// law `contact` is in contact.
    SpiralSearch {
        /// Name of a task with the law `pose` and the axes x and y of the base.
        #[schema(example = "search")]
        task: String,
        /// Distance of two turns, m.
        #[schema(example = 0.001)]
        pitch_m: f64,
        /// Speed along the spiral, m/s.
        #[schema(example = 0.01)]
        speed: f64,
        /// Depth below the place of the first contact at which the search ends, m. The task then holds the place.
        #[schema(example = 0.003)]
        inserted_m: f64,
    },
}

/// The programs of a scenario and what they remember.
#[derive(Debug, Clone)]
pub struct TargetPrograms(Vec<Program>);

#[derive(Debug, Clone)]
struct Program {
    task: String,
    state: ProgramState,
}

#[derive(Debug, Clone)]
enum ProgramState {
    AlongMotion(AlongMotion),
    Spiral(Spiral),
}

impl TargetPrograms {
    /// Returns the programs for a controller.
    pub fn new(streams: &[TargetProgram], controller: &wire::Controller) -> Result<Self, FieldError> {
        if streams.len() > MAX_STREAMS {
            return Err(FieldError::new("/target_programs", format!("has more than {MAX_STREAMS} programs")));
        }
        let program = |(i, stream)| Program::new(stream, controller, &format!("/target_programs/{i}"));
        streams.iter().enumerate().map(program).collect::<Result<_, _>>().map(Self)
    }

    /// Returns the targets of a period; `position`: the place of the tool (m), `presses`: whether the last answer has the first contact in the
    /// state `contact`.
    pub fn next(&mut self, position: [f64; 3], presses: bool) -> BTreeMap<String, wire::StreamedTarget> {
        let target = |program: &mut Program| {
            let target = match &mut program.state {
                ProgramState::AlongMotion(along) => along.next(position.into()),
                ProgramState::Spiral(spiral) => spiral.next(position, presses),
            };
            (program.task.clone(), target)
        };
        self.0.iter_mut().map(target).collect()
    }
}

impl Program {
    fn new(stream: &TargetProgram, controller: &wire::Controller, pointer: &str) -> Result<Self, FieldError> {
        let at = |field: &str| format!("{pointer}/{field}");
        let (task, axes, state) = match stream {
            TargetProgram::ForceAlongMotion { task, force, start_direction, memory_m } => {
                let direction = Vector3::from(*start_direction);
                direction.iter().try_for_each(|part| number(*part, &at("start_direction")).map(drop))?;
                let along = AlongMotion {
                    force: number(*force, &at("force"))?,
                    memory_m: positive(*memory_m, &at("memory_m"))?,
                    direction: direction
                        .try_normalize(1e-9)
                        .ok_or_else(|| FieldError::new(at("start_direction"), "must not be zero"))?,
                    last: None,
                };
                (task, [Axis::X, Axis::Y, Axis::Z].as_slice(), ProgramState::AlongMotion(along))
            }
            TargetProgram::SpiralSearch { task, pitch_m, speed, inserted_m } => {
                let spiral = Spiral {
                    pitch_m: positive(*pitch_m, &at("pitch_m"))?,
                    step_m: positive(*speed, &at("speed"))? * controller.period_s,
                    inserted_m: positive(*inserted_m, &at("inserted_m"))?,
                    start: None,
                    touch_m: None,
                    way_m: 0.0,
                    found: None,
                };
                (task, [Axis::X, Axis::Y].as_slice(), ProgramState::Spiral(spiral))
            }
        };
        let fits = |stated: &wire::ControllerTask| {
            stated.name == *task && stated.axes.as_deref() == Some(axes) && stated.frame == wire::Frame::Base
        };
        if !controller.tasks.iter().any(fits) {
            let problem = format!("names no task of the controller with the axes {axes:?} of the base");
            return Err(FieldError::new(at("task"), problem.to_lowercase()));
        }
        Ok(Self { task: task.clone(), state })
    }
}

/// A force that turns with the motion of the tool.
#[derive(Debug, Clone)]
struct AlongMotion {
    force: f64,
    memory_m: f64,
    /// Unit vector.
    direction: Vector3<f64>,
    /// The last place of the tool, m.
    last: Option<Vector3<f64>>,
}

impl AlongMotion {
    fn next(&mut self, position: Vector3<f64>) -> wire::StreamedTarget {
        let way = position - self.last.replace(position).unwrap_or(position);
        // A tool that returns along its way by `memory_m` at once has no direction; it keeps the last one.
        self.direction = (self.direction + way / self.memory_m).try_normalize(1e-9).unwrap_or(self.direction);
        let force = self.direction * self.force;
        wire::StreamedTarget { force: Some(force.as_slice().to_vec()), ..wire::StreamedTarget::default() }
    }
}

/// A search along a spiral.
#[derive(Debug, Clone)]
struct Spiral {
    pitch_m: f64,
    /// Way along the spiral in a period, m.
    step_m: f64,
    inserted_m: f64,
    /// Place of the tool at the start, m.
    start: Option<[f64; 3]>,
    /// Height of the first contact, m.
    touch_m: Option<f64>,
    /// Way along the spiral so far, m.
    way_m: f64,
    /// Place of the hole, m.
    found: Option<[f64; 2]>,
}

impl Spiral {
    fn next(&mut self, position: [f64; 3], presses: bool) -> wire::StreamedTarget {
        let [x, y, z] = position;
        let start = *self.start.get_or_insert(position);
        if presses {
            self.touch_m.get_or_insert(z);
        }
        if self.touch_m.is_some_and(|touch| (z - touch).abs() > self.inserted_m) {
            self.found.get_or_insert([x, y]);
        } else if presses {
            self.way_m += self.step_m;
        }
        let [right, ahead] = self.offset();
        let [x, y] = self.found.unwrap_or([start[0] + right, start[1] + ahead]);
        let pose = wire::StreamedPose { position: Some([x, y, start[2]]), orientation: None };
        wire::StreamedTarget { pose: Some(pose), ..wire::StreamedTarget::default() }
    }

    /// Returns the place on the spiral, seen from its middle, m. After n turns, the way along it is nearly π pitch n².
    fn offset(&self) -> [f64; 2] {
        let turns = (self.way_m / (PI * self.pitch_m)).sqrt();
        let (sin, cos) = (2.0 * PI * turns).sin_cos();
        [cos, sin].map(|part| self.pitch_m * turns * part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn controller() -> wire::Controller {
        let law = json!({"kind": "pose", "gain": 2});
        serde_json::from_value(json!({"robot": "panda", "period_s": 0.002, "tasks": [
            {"name": "pull", "axes": ["x", "y", "z"], "law": law},
            {"name": "search", "axes": ["x", "y"], "law": law},
        ]}))
        .unwrap()
    }

    fn streams(stream: serde_json::Value) -> Result<TargetPrograms, FieldError> {
        TargetPrograms::new(&[serde_json::from_value(stream).unwrap()], &controller())
    }

    /// On a circle of 0.3 m, the direction is behind by the angle of the memory: atan(5 mm/0.3 m).
    #[test]
    fn force_follows_a_circle() {
        let mut streams = streams(json!({"kind": "force_along_motion", "task": "pull", "force": 15,
            "start_direction": [2, 0, 0], "memory_m": 0.005}))
        .unwrap();
        let mut force = Vector3::zeros();
        for step in 0..=10_000 {
            let angle = f64::from(step) * 1e-4;
            let target = &streams.next([0.3 * angle.sin(), -0.3 * angle.cos(), 0.5], false)["pull"];
            force = Vector3::from_column_slice(target.force.as_ref().unwrap());
            if step == 0 {
                assert_eq!(force, Vector3::new(15.0, 0.0, 0.0));
            }
        }
        assert!((force.norm() - 15.0).abs() < 1e-12);
        let behind = 1.0 - force.y.atan2(force.x);
        assert!((behind - (0.005_f64 / 0.3).atan()).abs() < 1e-3, "{behind}");
    }

    #[test]
    fn spiral_has_its_pitch_and_its_speed_and_ends_in_the_hole() {
        let mut streams = streams(json!({"kind": "spiral_search", "task": "search", "pitch_m": 1e-3, "speed": 0.01,
            "inserted_m": 0.003}))
        .unwrap();
        let mut place = |height: f64, presses: bool| {
            let target = streams.next([0.4, 0.1, height], presses).remove("search").unwrap();
            let [x, y, z] = target.pose.unwrap().position.unwrap();
            assert_eq!(z, 0.5);
            [x - 0.4, y - 0.1]
        };
        assert_eq!(place(0.5, false), [0.0, 0.0]);
        assert_eq!(place(0.45, false), [0.0, 0.0], "it does not search before the touch");
        let way: Vec<[f64; 2]> = (0..1500).map(|_| place(0.4, true)).collect();
        let speed = |i: usize| (way[i + 1][0] - way[i][0]).hypot(way[i + 1][1] - way[i][1]) / 0.002;
        assert!([500, 1000, 1400].iter().all(|i| (speed(*i) - 0.01).abs() < 2e-4), "{}", speed(500));
        // 30 mm of way are 3.09 turns.
        let [x, y] = *way.last().unwrap();
        assert!((x.hypot(y) - 3.09e-3).abs() < 1e-5, "{}", x.hypot(y));
        // In the hole, the place is that of the tool, also when it presses on the bottom.
        assert_eq!(place(0.396, true), [0.0, 0.0]);
        assert_eq!(place(0.38, true), [0.0, 0.0]);
    }

    #[test]
    fn errors_name_the_field() {
        let pointer = |stream| streams(stream).map(drop).unwrap_err().pointer;
        let spiral = |task: &str, pitch: f64| json!({"kind": "spiral_search", "task": task, "pitch_m": pitch, "speed": 0.01, "inserted_m": 0.003});
        assert_eq!(pointer(spiral("pull", 1e-3)), "/target_programs/0/task");
        assert_eq!(pointer(spiral("none", 1e-3)), "/target_programs/0/task");
        assert_eq!(pointer(spiral("search", 0.0)), "/target_programs/0/pitch_m");
        let pull = json!({"kind": "force_along_motion", "task": "pull", "force": 15, "start_direction": [0, 0, 0],
            "memory_m": 0.005});
        assert_eq!(pointer(pull), "/target_programs/0/start_direction");
    }
}
