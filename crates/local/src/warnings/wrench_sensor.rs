//! Warnings about wrench sensors whose numbers look like those of another unit.

use revprio_api::wire::{self, Payload, WrenchSensor};
use revprio_lab::number::significant;

/// Largest payload that is no mistake, kg. Most arms lift less.
const MOST_KG: f64 = 100.0;

/// Largest distance of a sensor from its tip, and of a centre of mass from its sensor, m.
const FARTHEST: f64 = 2.0;

/// Magnitudes of gravity, m/s²: the Moon has 1.6. Zero switches it off.
const GRAVITY: std::ops::RangeInclusive<f64> = 1.5..=30.0;

/// Returns a warning for each number of a sensor that is valid and probably has another unit.
pub fn warnings(request: &wire::Controller) -> impl Iterator<Item = String> {
    let tool = request.wrench_sensor.iter().map(|sensor| ("wrench_sensor".to_owned(), sensor));
    let others = request.wrench_sensors.iter().map(|(tip, sensor)| (format!("wrench_sensors.{tip}"), sensor));
    tool.chain(others).flat_map(|(place, sensor)| of_sensor(&place, sensor))
}

fn of_sensor(place: &str, sensor: &WrenchSensor) -> Vec<String> {
    let Payload { mass_kg, center_of_mass } = sensor.payload;
    let lengths = [
        (sensor.pose.as_ref().map_or(0.0, |pose| length(&pose.position)), "pose", "the sensor is", "its tip"),
        (length(&center_of_mass), "payload.center_of_mass", "the centre of mass is", "the sensor"),
    ];
    let far = lengths.into_iter().filter(|(distance, ..)| *distance > FARTHEST);
    let mut warnings: Vec<String> = far
        .map(|(distance, field, what, from)| {
            let distance = significant(distance, 3);
            format!("`{place}.{field}`: {what} {distance} m away from {from}; give metres")
        })
        .collect();
    if mass_kg > MOST_KG {
        warnings.push(format!("`{place}.payload.mass_kg`: {mass_kg} kg are more than most arms lift; give kilograms"));
    }
    let gravity = length(&sensor.gravity);
    if mass_kg > 0.0 && gravity > 0.0 && !GRAVITY.contains(&gravity) {
        warnings.push(format!(
            "`{place}.gravity`: {} m/s² is no gravity of a planet, so the weight of the payload is wrong; give m/s², as \
             [0, 0, -9.81]",
            significant(gravity, 3)
        ));
    }
    warnings
}

fn length(vector: &[f64; 3]) -> f64 {
    vector.iter().fold(0.0, |length: f64, entry| length.hypot(*entry))
}
