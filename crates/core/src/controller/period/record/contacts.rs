//! The axes with the contact law after a command: they are told the velocity that is achieved.

use crate::controller::config::ControllerConfig;
use crate::controller::period::aim::Contacts;
use crate::law::ContactAxis;
use crate::limits::DriveState;
use crate::resolution::Resolution;
use crate::task::TaskStack;

/// Overwrites what the axes remember. `drive`: that before the command; `tasks`: with the Jacobians of the period.
pub(super) fn update(
    remembered: &mut Vec<ContactAxis>,
    (config, drive): (&ControllerConfig, &DriveState),
    contacts: &Contacts,
    tasks: &TaskStack,
    resolution: &Resolution,
) {
    remembered.clear();
    let period = config.period_s;
    for axis in contacts.axes() {
        let jacobian = &tasks.tasks()[axis.task].jacobian;
        let moved: f64 = (0..jacobian.ncols())
            .map(|joint| {
                jacobian[(axis.row, joint)] * drive.way(config.drive, joint, &resolution.joint_velocity, period)
            })
            .sum();
        let way = axis.direction * moved / config.weight(axis.task, axis.row);
        let mut memory = axis.memory;
        memory.advance(&axis.timing, way, period);
        remembered.push(memory);
    }
}
