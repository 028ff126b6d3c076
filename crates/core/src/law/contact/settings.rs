//! What a contact law must be told about one axis.

/// Lever that compares a rotation with a translation, m: 1 N·m on an axis of rotation counts as 10 N, 1 rad as 0.1 m.
const LEVER: f64 = 0.1;

/// Default of the noise of the measured force, rms, N.
const NOISE: f64 = 0.2;

/// Default of the stiffest contact, N/m. No arm with its tool and its sensor is stiffer.
const STIFFEST: f64 = 1e6;

/// Softest contact, N/m.
const SOFTEST: f64 = 300.0;

/// Fastest retreat, m/s.
const RETREAT_SPEED: f64 = 0.25;

/// Default of the time constant of the force sensor, s.
const SENSOR_LAG: f64 = 0.002;

/// Largest acceleration that the law uses, m/s², whatever the joints could give.
const MAX_ACCELERATION: f64 = 5.0;

/// f_off as a share of f₅. A force of f₅/2 that stays where nothing is pressed is then noticed in spite of noise, and one of f₅ is not lost.
const RELEASE: f64 = 0.65;

/// Mass of a tool that does not look like a contact when an approach begins, kg.
const TOOL_MASS: f64 = 1.0;

/// Smallest acceleration with which an approach begins, m/s²: with a sensor of little noise.
const SLOWEST_START: f64 = 0.5;

/// Fastest surface that the law follows for long, m/s. It limits the power that the law gives to the surface.
const FOLLOWED_SPEED: f64 = 0.05;

/// What is known of the contact along one axis. For an axis of rotation read N·m for N and rad for m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSettings {
    /// v_app, speed at which the tool approaches, m/s; `None`: the largest one that keeps 1.2 F_d.
    pub approach_speed: Option<f64>,
    /// K_max, stiffness of the stiffest contact, N/m.
    pub stiffest: f64,
    /// K_min, stiffness of the softest contact, N/m.
    pub softest: f64,
    /// σ, rms of the noise of the measured force, N.
    pub noise: f64,
    /// b, bound of the error of the measured force, such as a bias or the inertia of the tool, N.
    pub bias: f64,
    /// τ_f, time constant of the force sensor, s.
    pub sensor_lag: f64,
    /// Force at which the tool retreats, N; infinite: none.
    pub max_force: f64,
    /// v_ret, fastest retreat, m/s.
    pub retreat_speed: f64,
    /// Largest acceleration that the law uses, m/s²; the joints may permit less.
    pub max_acceleration: f64,
    /// P_in/F_d, speed of a surface that the law follows for as long as needed, m/s.
    pub followed_speed: f64,
    /// 1 m in the unit of positions: 1, or 10 rad.
    pub metre: f64,
}

impl ContactSettings {
    /// The defaults of a translation.
    pub const LINEAR: Self = Self {
        approach_speed: None,
        stiffest: STIFFEST,
        softest: SOFTEST,
        noise: NOISE,
        bias: 0.0,
        sensor_lag: SENSOR_LAG,
        max_force: f64::INFINITY,
        retreat_speed: RETREAT_SPEED,
        max_acceleration: MAX_ACCELERATION,
        followed_speed: FOLLOWED_SPEED,
        metre: 1.0,
    };

    /// The defaults of a rotation: those of a translation at a lever of 0.1 m.
    pub const ANGULAR: Self = Self {
        approach_speed: None,
        stiffest: STIFFEST * LEVER * LEVER,
        softest: SOFTEST * LEVER * LEVER,
        noise: NOISE * LEVER,
        bias: 0.0,
        sensor_lag: SENSOR_LAG,
        max_force: f64::INFINITY,
        retreat_speed: RETREAT_SPEED / LEVER,
        max_acceleration: MAX_ACCELERATION / LEVER,
        followed_speed: FOLLOWED_SPEED / LEVER,
        metre: 1.0 / LEVER,
    };

    /// Largest noise of an axis of translation, N.
    pub const MOST_NOISE: f64 = 10.0;

    /// Least speed, m/s, and acceleration, m/s², of an axis; rad for m. With much less, the time of a stop overflows.
    pub const LEAST_MOTION: f64 = 1e-9;

    /// Largest bias of an axis of translation, N.
    pub const MOST_BIAS: f64 = 100.0;

    /// Returns the defaults of an axis of rotation or of translation.
    pub const fn of(is_angular: bool) -> Self {
        if is_angular { Self::ANGULAR } else { Self::LINEAR }
    }

    /// Returns whether the axis is one of rotation.
    pub fn is_angular(&self) -> bool {
        self.metre != 1.0
    }

    /// Returns the acceleration with which an approach begins, m/s²: the inertia of 1 kg that is not compensated then reads f₃, without
    /// noise. No approach begins with less than 0.5 m/s².
    pub(super) fn approach_acceleration(&self) -> f64 {
        let inertia = TOOL_MASS / (self.metre * self.metre);
        (self.suspicion() / inertia).max(SLOWEST_START * self.metre)
    }

    /// Returns f₃ = 3 σ + b, the force from which a contact is suspected, N.
    pub fn suspicion(&self) -> f64 {
        3.0 * self.noise + self.bias
    }

    /// Returns f₅ = 5 σ + b, the force that is a contact, N.
    pub fn threshold(&self) -> f64 {
        5.0 * self.noise + self.bias
    }

    /// Returns f_off, the force below which the contact is in doubt, N.
    pub fn release(&self) -> f64 {
        RELEASE * self.threshold()
    }
}

impl Default for ContactSettings {
    fn default() -> Self {
        Self::LINEAR
    }
}
