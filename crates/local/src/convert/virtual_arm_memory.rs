//! The virtual arm in the memory of stateless steps.

use revprio_api::wire;
use revprio_core::controller::{Line, VirtualArm};

use super::checks::{Inside, Result, each};
use super::numbers::{number, numbers};

/// Reads the virtual arm. The controller checks its sizes and ranges.
pub fn virtual_arm(arm: &wire::VirtualArm) -> Result<VirtualArm> {
    Ok(VirtualArm {
        postures: postures(&arm.postures)?,
        next: usize::try_from(arm.next).unwrap_or(usize::MAX),
        target_accelerations: each("/target_accelerations", &arm.target_accelerations, |_, entries| {
            numbers(entries, "")
        })?,
        line: arm.line.as_ref().map(line).transpose().inside("/line")?,
    })
}

fn postures(given: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
    each("/postures", given, |_, posture| numbers(posture, ""))
}

fn line(line: &wire::Line) -> Result<Line> {
    Ok(Line {
        offset: numbers(&line.offset, "/offset")?,
        progress: number(line.progress, "/progress")?,
        speed: number(line.speed, "/speed")?,
        postures: postures(&line.postures)?,
        speeds: numbers(&line.speeds, "/speeds")?,
        is_given_up: line.is_given_up,
    })
}

/// Returns the virtual arm as a part of an answer.
pub fn virtual_arm_answer(arm: &VirtualArm) -> wire::VirtualArm {
    let line = |line: &Line| wire::Line {
        offset: line.offset.clone(),
        progress: line.progress,
        speed: line.speed,
        postures: line.postures.clone(),
        speeds: line.speeds.clone(),
        is_given_up: line.is_given_up,
    };
    wire::VirtualArm {
        postures: arm.postures.clone(),
        next: u32::try_from(arm.next).unwrap_or(u32::MAX),
        target_accelerations: arm.target_accelerations.clone(),
        line: arm.line.as_ref().map(line),
    }
}
