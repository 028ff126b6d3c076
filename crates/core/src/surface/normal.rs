//! The normal of a surface whose direction is not known.
//!
//! A tool that slides on a surface moves along a tangent d, and friction acts along d. So the force of the tool on the surface is
//! f = N (n + μ d), and
//!
//! f − (d·f) d = N n, d·f = μ N,
//!
//! whatever μ is. The direction d comes from the motion: it is the chord between two places of the tool that are [`CHORD`] apart, less
//! what the tool went deeper into a soft surface. A tool that stands, or turns back, makes no chord, and teaches nothing.
//!
//! Vectors are along the axes of the base.

use std::f64::consts::PI;

use nalgebra::{Rotation3, Unit, Vector3};

/// Length of a chord, m. Shorter ones follow curves better, and are less exact.
const CHORD: f64 = 1e-3;

/// Way over which the normal is a mean, m.
const WAY: f64 = 5e-3;

/// Time constant of the filters of position and force, s. It is the same for both, so places and forces still belong together.
const FILTER: f64 = 0.02;

/// Largest way into the surface over the chord: the stiffness is not known so well that more could be subtracted.
const DEEPER: f64 = 0.25;

/// Largest coefficient of friction. A chord that shows more is none of a sliding tool: it presses, or hits an edge.
const MOST_FRICTION: f64 = 1.0;

/// Fastest turn of the normal, rad/s.
const TURN_RATE: f64 = 2.0;

/// Speed along a surface whose normal is not known, m/s.
const UNKNOWN_SPEED: f64 = 5e-3;

/// Factor by which that speed grows with each chord.
const FASTER: f64 = 1.3;

/// Chords after which the normal is known.
const KNOWN: f64 = 20.0;

/// How a task follows the normal of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceSettings {
    /// Largest angle between the normal and the stated axis, rad.
    pub max_tilt: f64,
}

impl SurfaceSettings {
    /// Largest angle that can be stated, rad: beyond it the stated axis says nothing about the surface.
    pub const MOST_TILT: f64 = 1.4;
}

impl Default for SurfaceSettings {
    fn default() -> Self {
        Self { max_tilt: std::f64::consts::FRAC_PI_4 }
    }
}

/// How a tool and a surface meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Touch {
    /// The tool has not touched the surface yet.
    #[default]
    Free,
    /// The tool presses.
    Touches,
    /// The tool has left the surface, and may come back to it.
    Left,
}

/// What is known of the normal of a surface. All zero before the first period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalEstimate {
    /// n, the direction in which the task presses, a unit vector.
    pub normal: Vector3<f64>,
    /// Mean of the normals of the chords; zero before the first one.
    pub mean: Vector3<f64>,
    /// μ.
    pub friction: f64,
    /// Mean of the squared angle between `mean` and the normals of the chords, rad².
    pub variance: f64,
    /// Number of chords since the touch, up to 20.
    pub chords: f64,
    /// Whether the filters have begun.
    pub is_sliding: bool,
    /// Filtered position of the tool, m.
    pub position: Vector3<f64>,
    /// Filtered force of the tool on the surface, N.
    pub force: Vector3<f64>,
    /// Both where the present chord begins.
    pub begin: [Vector3<f64>; 2],
}

/// What the estimate is told in a period.
#[derive(Debug, Clone, Copy)]
pub struct SlidingInput {
    /// The stated pressing direction, a unit vector.
    pub stated: Vector3<f64>,
    /// Position of the tool, m.
    pub position: Vector3<f64>,
    /// Force of the tool on the surface, N.
    pub force: Vector3<f64>,
    /// How tool and surface meet.
    pub touch: Touch,
    /// Best known stiffness along the normal, N/m.
    pub stiffness: f64,
    /// The smallest that it may be, N/m: the same once it is known.
    pub softest: f64,
    /// Time since the last period, s.
    pub time: f64,
}

/// What the contact law tells about the normal of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalReport {
    /// n, the direction in which the task presses, along the axes of the base.
    pub normal: Vector3<f64>,
    /// μ, estimated coefficient of friction; `None`: the tool has not slid yet.
    pub friction: Option<f64>,
    /// Rms angle between the estimate and single measurements of the normal, rad; `None`: the tool has not slid yet.
    pub deviation: Option<f64>,
    /// Whether the largest tilt holds the normal back.
    pub is_limited: bool,
    /// Largest speed along the surface until its normal is known, m/s; `None`: it is known, or the tool does not touch it.
    pub most_speed: Option<f64>,
}

impl NormalEstimate {
    /// The estimate before the first period.
    pub const START: Self = Self {
        normal: Vector3::new(0.0, 0.0, 0.0),
        mean: Vector3::new(0.0, 0.0, 0.0),
        friction: 0.0,
        variance: 0.0,
        chords: 0.0,
        is_sliding: false,
        position: Vector3::new(0.0, 0.0, 0.0),
        force: Vector3::new(0.0, 0.0, 0.0),
        begin: [Vector3::new(0.0, 0.0, 0.0); 2],
    };

    /// Returns whether all numbers are finite and in their ranges.
    pub fn is_valid(&self) -> bool {
        let vectors = [self.normal, self.mean, self.position, self.force, self.begin[0], self.begin[1]];
        let is_unit = |vector: &Vector3<f64>| (vector.norm() - 1.0).abs() < 1e-6;
        vectors.iter().all(|vector| vector.iter().all(|entry| entry.is_finite()))
            && (self.normal == Vector3::zeros() || is_unit(&self.normal))
            && self.mean.norm() <= 1.0 + 1e-6
            && (0.0..=MOST_FRICTION).contains(&self.friction)
            && (0.0..=PI * PI).contains(&self.variance)
            && (0.0..=KNOWN).contains(&self.chords)
    }

    /// Returns the estimate with n within an angle (rad) of the stated direction: a memory may say anything.
    #[must_use]
    pub fn within(self, stated: &Vector3<f64>, angle: f64) -> Self {
        let normal = self.normal.try_normalize(0.5).map(|normal| within(&normal, stated, angle).0);
        Self { normal: normal.unwrap_or(self.normal), ..self }
    }

    /// Returns n; before the first period the stated direction.
    pub fn direction(&self, stated: &Vector3<f64>) -> Vector3<f64> {
        self.normal.try_normalize(0.5).unwrap_or(*stated)
    }

    /// Returns the smallest rotation from the stated direction to n.
    pub fn turn(&self, stated: &Vector3<f64>) -> Rotation3<f64> {
        Rotation3::rotation_between(stated, &self.direction(stated)).unwrap_or_else(Rotation3::identity)
    }

    /// Updates the estimate by a period; returns its report.
    pub fn update(&mut self, settings: SurfaceSettings, input: &SlidingInput) -> NormalReport {
        let before = self.direction(&input.stated);
        match input.touch {
            Touch::Touches => self.slide(settings, &before, input),
            Touch::Free => *self = Self::START,
            Touch::Left => self.is_sliding = false,
        }
        // An approach is along the stated direction again; a lost surface is sought where it was.
        let goal = match input.touch {
            Touch::Free => input.stated,
            Touch::Touches | Touch::Left => self.mean.try_normalize(0.0).unwrap_or(before),
        };
        let (goal, is_limited) = within(&goal, &input.stated, settings.max_tilt);
        self.normal = within(&goal, &before, TURN_RATE * input.time).0;
        let is_known = self.chords > 0.0;
        NormalReport {
            normal: self.normal,
            friction: is_known.then_some(self.friction),
            deviation: is_known.then(|| self.variance.sqrt()),
            is_limited,
            most_speed: self.most_speed(input.touch),
        }
    }

    /// Returns the largest speed along the surface, m/s, until the normal is known.
    ///
    /// A surface that the tool slides up or down at v comes or recedes at v tan(tilt), and a law behind a lag cannot follow a stiff one.
    fn most_speed(&self, touch: Touch) -> Option<f64> {
        let is_known = self.chords >= KNOWN;
        (touch != Touch::Free && !is_known).then(|| UNKNOWN_SPEED * FASTER.powf(self.chords))
    }

    /// Filters position and force, and ends a chord that is long enough.
    fn slide(&mut self, settings: SurfaceSettings, normal: &Vector3<f64>, input: &SlidingInput) {
        if !self.is_sliding {
            (self.position, self.force) = (input.position, input.force);
            (self.is_sliding, self.begin) = (true, [input.position, input.force]);
            return;
        }
        let share = -(-input.time / FILTER).exp_m1();
        self.position += share * (input.position - self.position);
        self.force += share * (input.force - self.force);
        let [place, force] = self.begin;
        let change = normal.dot(&(self.force - force));
        let chord = self.position - place - change / input.stiffness * normal;
        let length = chord.norm();
        if length >= CHORD {
            let force = 0.5 * (force + self.force);
            self.begin = [self.position, self.force];
            if (change / input.softest).abs() <= DEEPER * length {
                self.add(settings, &(chord / length), length, &force);
            }
        }
    }

    /// Adds a chord along the unit vector d, of a length (m), with the mean force (N).
    fn add(&mut self, settings: SurfaceSettings, chord: &Vector3<f64>, length: f64, force: &Vector3<f64>) {
        let along = chord.dot(force);
        let across = force - along * chord;
        let pressing = across.norm();
        if !(along.abs() <= MOST_FRICTION * pressing) {
            return;
        }
        let normal = across / pressing;
        // The way of the first chords is that since the touch. A long one, after missing states, is one all the same.
        let of_way = (length / WAY).min(0.5);
        let share = of_way.max(1.0 / (self.chords + 1.0));
        self.mean += share * (normal - self.mean);
        self.friction += share * ((along / pressing).max(0.0) - self.friction);
        // One chord does not know how exact it is: the largest tilt is where that begins.
        let variance = if self.chords > 0.0 { self.variance } else { settings.max_tilt * settings.max_tilt };
        self.variance = variance + of_way * (self.mean.angle(&normal).powi(2) - variance);
        self.chords = (self.chords + 1.0).min(KNOWN);
    }
}

/// Returns the unit vector within an angle (rad) of another one, that is nearest to a given one, and whether it is another one.
fn within(given: &Vector3<f64>, of: &Vector3<f64>, angle: f64) -> (Vector3<f64>, bool) {
    if given.angle(of) <= angle {
        return (*given, false);
    }
    // Opposite vectors have no axis; any one will do.
    let aside = if of.x.abs() < 0.8 { Vector3::x() } else { Vector3::y() };
    let axis = of.cross(given).try_normalize(1e-9).unwrap_or_else(|| of.cross(&aside).normalize());
    (Rotation3::from_axis_angle(&Unit::new_unchecked(axis), angle) * of, true)
}
