//! Warnings about bounds of the states below the force that a law presses with.

use revprio_api::wire;
use revprio_core::controller::ControllerConfig;

/// Returns a warning for each row of a law `contact` whose target force is beyond what states may have.
pub fn warnings(request: &wire::Controller, config: &ControllerConfig) -> impl Iterator<Item = String> {
    let checks = request.state_checks;
    config.tasks.iter().filter_map(|task| Some((task, task.law.contact()?))).flat_map(move |(task, law)| {
        let rows = law.axes().iter().zip(law.target_force().largest());
        rows.filter_map(move |(axis, target)| {
            let (field, bound, unit) = if axis.is_angular() {
                ("max_torque_nm", checks.max_torque_nm?, "N·m")
            } else {
                ("max_force_n", checks.max_force_n?, "N")
            };
            let target = target.abs();
            (bound < target).then(|| {
                format!(
                    "task `{}` presses with up to {target} {unit}, and states above `state_checks.{field}`, {bound} {unit}, are refused; set it \
                     to the range of the sensor",
                    task.name
                )
            })
        })
    })
}
