//! Set-points over time.

use crate::linalg::Vector;

/// A set-point as a function of time, m rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    offset: Vector,
    /// A swing about the offset: amplitude, angular frequency (rad/s), phase (rad).
    sine: Option<(Vector, f64, f64)>,
}

/// Why a profile is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ProfileError {
    /// A value is NaN or infinite.
    #[error("profile values must be finite numbers")]
    NotFinite,
    /// Offset and amplitude differ in size.
    #[error("{offset} offsets, but {amplitude} amplitudes; give one of each per axis")]
    Size {
        /// Rows of the offset.
        offset: usize,
        /// Rows of the amplitude.
        amplitude: usize,
    },
}

impl Profile {
    /// The same value for ever.
    pub fn constant(value: Vec<f64>) -> Result<Self, ProfileError> {
        finite(&value)?;
        Ok(Self { offset: Vector::from_vec(value), sine: None })
    }

    /// offset + amplitude sin(ω t + φ), with ω `angular_frequency` in rad/s and φ `phase` in rad.
    pub fn sine(
        offset: Vec<f64>,
        amplitude: Vec<f64>,
        angular_frequency: f64,
        phase: f64,
    ) -> Result<Self, ProfileError> {
        finite(&offset)?;
        finite(&amplitude)?;
        finite(&[angular_frequency, phase])?;
        if offset.len() != amplitude.len() {
            return Err(ProfileError::Size { offset: offset.len(), amplitude: amplitude.len() });
        }
        Ok(Self {
            offset: Vector::from_vec(offset),
            sine: Some((Vector::from_vec(amplitude), angular_frequency, phase)),
        })
    }

    /// m.
    pub fn rows(&self) -> usize {
        self.offset.len()
    }

    /// The value at time t, s.
    pub fn at(&self, time_s: f64) -> Vector {
        match &self.sine {
            None => self.offset.clone(),
            Some((amplitude, omega, phase)) => &self.offset + amplitude * (omega * time_s + phase).sin(),
        }
    }
}

fn finite(values: &[f64]) -> Result<(), ProfileError> {
    if values.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(ProfileError::NotFinite) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_swings_about_its_offset() {
        // Eq. (54): 30 + 5 sin(t/π).
        let profile = Profile::sine(vec![30.0], vec![5.0], std::f64::consts::FRAC_1_PI, 0.0).unwrap();
        assert_eq!(profile.at(0.0)[0], 30.0);
        assert!((profile.at(2.0)[0] - (30.0 + 5.0 * (2.0 / std::f64::consts::PI).sin())).abs() < 1e-14);
    }

    #[test]
    fn profiles_that_give_no_number_do_not_exist() {
        assert_eq!(Profile::constant(vec![f64::NAN]), Err(ProfileError::NotFinite));
        assert_eq!(Profile::sine(vec![1.0], vec![], 1.0, 0.0), Err(ProfileError::Size { offset: 1, amplitude: 0 }));
    }
}
