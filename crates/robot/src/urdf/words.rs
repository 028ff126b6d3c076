//! What the names of links and joints say about them.

/// The words of a name in lower case: `LeftWrist_tool0` has the words left, wrist, tool, 0.
pub fn words(name: &str) -> Vec<String> {
    let characters: Vec<char> = name.chars().collect();
    let mut words = vec![String::new()];
    for (i, now) in characters.iter().copied().enumerate() {
        let before = i.checked_sub(1).map_or('_', |i| characters[i]);
        let next_is_lower = characters.get(i + 1).is_some_and(|next| next.is_lowercase());
        let begins = now.is_uppercase() && (before.is_lowercase() || next_is_lower);
        let digits_change = now.is_ascii_digit() != before.is_ascii_digit();
        if begins || digits_change || !now.is_alphanumeric() {
            words.push(String::new());
        }
        if let (true, Some(word)) = (now.is_alphanumeric(), words.last_mut()) {
            word.extend(now.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

fn any(words: &[String], listed: &[&str]) -> bool {
    words.iter().any(|word| listed.contains(&word.as_str()))
}

fn any_contains(words: &[String], listed: &[&str]) -> bool {
    words.iter().any(|word| listed.iter().any(|part| word.contains(part)))
}

/// Whether the words name a finger.
pub fn is_finger(words: &[String]) -> bool {
    any_contains(words, &["finger", "thumb", "knuckle"]) || any(words, &["jaw", "claw", "pinky"])
}

/// Whether the name is just `fingertip`: the end of an arm without a gripper.
pub fn is_only_fingertip(words: &[String]) -> bool {
    matches!(words, [word] if word == "fingertip")
}

/// Whether the words name a joint that closes a gripper, not one that turns it.
pub fn is_gripper_joint(words: &[String]) -> bool {
    is_finger(words) || (any_contains(words, &["gripper"]) && !turns(words))
}

/// Whether the words say that something turns.
fn turns(words: &[String]) -> bool {
    any(words, &["yaw", "pitch", "roll", "rotate", "rotation", "twist"])
}

/// Whether the words name a joint that turns a gripper.
pub fn turns_gripper(words: &[String]) -> bool {
    any(words, &["gripper"]) && turns(words)
}

/// Whether the words name a part of an arm.
pub fn is_arm(words: &[String]) -> bool {
    any_contains(words, &["arm", "shoulder", "elbow", "wrist"])
}

/// Whether the words name a head.
pub fn is_head(words: &[String]) -> bool {
    any(words, &["head", "neck", "eye", "eyes", "eyelids", "gaze"])
}

/// Whether the words name a leg or a wheel.
pub fn is_leg_or_wheel(words: &[String]) -> bool {
    const LEG: [&str; 13] =
        ["leg", "hip", "thigh", "knee", "calf", "shank", "ankle", "foot", "feet", "toe", "toes", "sole", "haa"];
    any(words, &LEG) || any_contains(words, &["wheel", "caster", "suspension"])
}

/// Whether the words name a sensor or a drawing.
pub fn is_sensor(words: &[String]) -> bool {
    const SENSOR: [&str; 11] =
        ["imu", "cam", "range", "sonar", "gps", "skin", "visual", "led", "com", "inertia", "collision"];
    const PARTS: [&str; 8] =
        ["camera", "laser", "lidar", "velodyne", "sensor", "accelerometer", "optical", "realsense"];
    any(words, &SENSOR) || any_contains(words, &PARTS)
}

/// How well the words name a tool frame: 0 is best; `None` if they name none.
pub fn tool_rank(words: &[String]) -> Option<usize> {
    const RANKED: [&[&str]; 8] = [
        &["tool"],
        &["flange", "attachment"],
        &["tcp"],
        &["ee", "eef", "effector", "endeffector", "endpoint", "tip"],
        &["grasp", "grasping", "grasptarget", "grip", "pinch"],
        &["hand", "palm"],
        &["gripper"],
        &["fingertip"],
    ];
    // `ee_x` is the drawing of an axis.
    let is_axis = any(words, &["x", "y", "z"]);
    RANKED.iter().position(|listed| any(words, listed) && !turns(words) && !is_axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str) -> Vec<String> {
        words(name)
    }

    #[test]
    fn names_are_split_at_underscores_digits_and_capitals() {
        assert_eq!(of("LeftWrist_tool0"), ["left", "wrist", "tool", "0"]);
        assert_eq!(of("LHipYaw"), ["l", "hip", "yaw"]);
        assert_eq!(of("RARM-WRIST.2"), ["rarm", "wrist", "2"]);
        assert!(of("_").is_empty() && of("").is_empty());
    }

    #[test]
    fn a_joint_that_turns_a_gripper_does_not_close_it() {
        assert!(is_gripper_joint(&of("jointGripper")) && is_gripper_joint(&of("panda_leftfinger")));
        assert!(!is_gripper_joint(&of("LeftGripperYaw")) && !is_gripper_joint(&of("wrist_roll")));
    }

    #[test]
    fn tool_frames_are_ranked() {
        let ranks: Vec<_> =
            ["tool0", "flange", "attachment_site", "panda_hand_tcp", "link_eef", "grip_site", "panda_hand", "link_6"]
                .map(|name| tool_rank(&of(name)))
                .into();
        assert_eq!(ranks, [Some(0), Some(1), Some(1), Some(2), Some(3), Some(4), Some(5), None]);
        assert_eq!([tool_rank(&of("ee_x")), tool_rank(&of("ee_x_fixed"))], [None; 2]);
    }
}
