//! A scenario in a few sentences. The page shows all of its fields as JSON next to them.

use revprio_api::wire;

use crate::number::{significant, trimmed};
use crate::simulator::{Contact, ContactKind, Scenario};

/// Returns sentences about the robot, the contacts, the tasks and the expected result.
#[must_use]
pub fn sentences(scenario: &Scenario, robot: &wire::Robot) -> Vec<String> {
    let mut sentences = vec![format!("{}.", scenario.description.trim_end_matches('.')), start(scenario, robot)];
    sentences.extend(scenario.contacts.iter().map(contact));
    let tasks: Vec<&str> = scenario.controller.tasks.iter().map(|task| task.name.as_str()).collect();
    sentences.push(format!("Tasks, highest priority first: {}.", tasks.join("; ")));
    if !scenario.expectation.is_empty() {
        sentences.push(format!("Expected result: {}.", scenario.expectation.trim_end_matches('.')));
    }
    sentences
}

fn start(scenario: &Scenario, robot: &wire::Robot) -> String {
    let posture = scenario.start_joint_position.iter().map(|q| trimmed(*q)).collect::<Vec<_>>().join(", ");
    format!(
        "The robot {} ({} joints) starts at rest at q = ({posture}). It receives a command every {} ms for {} s.",
        robot.name,
        robot.joints.len(),
        trimmed(1e3 * scenario.period_s()),
        trimmed(scenario.duration_s)
    )
}

fn contact(contact: &Contact) -> String {
    let kind = match contact.kind {
        ContactKind::Spring => "spring",
        ContactKind::Wall => "wall",
        ContactKind::Plane => "plane",
        ContactKind::Cylinder => "cylinder",
        ContactKind::Sphere => "sphere",
        ContactKind::Door => "door",
    };
    let axis = contact.axis.map(|axis| format!(" along {}", ["x", "y", "z"][axis])).unwrap_or_default();
    format!(
        "Contact: a {kind}{axis} of {} N/m, {} mm from the start position of the tool.",
        significant(contact.stiffness, 3),
        trimmed(1e3 * contact.offset_m)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robot_contact_tasks_and_expectation_are_described() {
        let scenario = Scenario::find("stiff_wall_lag").unwrap();
        let robot = wire::Robot {
            shapes: None,
            name: "sawyer_dh".to_owned(),
            description: String::new(),
            source: wire::RobotSource::DenavitHartenberg,
            joints: Vec::new(),
            tips: Vec::new(),
            links: Vec::new(),
            chain: None,
        };
        let text = sentences(&scenario, &robot).join("\n");
        for part in [
            "starts at rest at q = (2.9, −0.4, 3, 2.1, 3, −0.6, 0.2). It receives a command every 1 ms for 5 s.",
            "Contact: a wall along x of 1.00e5 N/m, 50 mm from the start position of the tool.",
            "Tasks, highest priority first: push x; hold.",
            "Expected result: ",
        ] {
            assert!(text.contains(part), "`{part}` is not in\n{text}");
        }
    }
}
