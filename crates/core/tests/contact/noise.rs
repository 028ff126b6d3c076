//! White noise.

/// A small generator: xorshift with the method of Box and Muller.
pub struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Self {
        let mut noise = Self(seed.wrapping_mul(2_654_435_761).wrapping_add(88_172_645_463_325_252));
        for _ in 0..8 {
            noise.uniform();
        }
        noise
    }

    /// A number between 0 and 1.
    pub fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / 9_007_199_254_740_992.0
    }

    /// A number between two positive ones, uniform in its logarithm.
    pub fn between(&mut self, least: f64, most: f64) -> f64 {
        least * (most / least).powf(self.uniform())
    }

    pub fn normal(&mut self) -> f64 {
        let (u, v) = (self.uniform() + 1e-300, self.uniform());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).sin()
    }
}
