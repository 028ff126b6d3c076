//! Semantic descriptions of robots (SRDF): which links never have to keep clear of each other, and where the hands are.

use crate::UrdfError;
use crate::urdf::{parse, robot};

/// The parts of a semantic description that a robot needs. Groups, states and passive joints are not read.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Srdf {
    /// `<end_effector>` elements.
    pub end_effectors: Vec<EndEffector>,
    /// `<disable_collisions>` elements.
    pub disabled: Vec<DisabledPair>,
}

/// A hand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EndEffector {
    /// Its name.
    pub name: String,
    /// The link to which it is attached.
    pub parent_link: String,
}

/// A pair of links that need not keep clear of each other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DisabledPair {
    /// The links.
    pub links: [String; 2],
    /// Why, as the description says, for example `Adjacent` or `Never`; may be empty.
    pub reason: String,
}

impl Srdf {
    /// Reads a description.
    pub fn read(text: &str) -> Result<Self, UrdfError> {
        let document = parse(text)?;
        let root = robot(&document)?;
        let mut read = Self::default();
        for node in root.children() {
            let attribute = |name: &str| node.attribute(name).unwrap_or_default().to_owned();
            match node.tag_name().name() {
                "end_effector" => {
                    let (name, parent_link) = (attribute("name"), attribute("parent_link"));
                    read.end_effectors.push(EndEffector { name, parent_link });
                }
                "disable_collisions" => {
                    let links = [attribute("link1"), attribute("link2")];
                    read.disabled.push(DisabledPair { links, reason: attribute("reason") });
                }
                _ => {}
            }
        }
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn end_effectors_and_disabled_pairs_are_read_with_their_reasons() {
        let text = r#"
          <robot name="two">
            <group name="arm"><chain base_link="base" tip_link="wrist"/></group>
            <end_effector name="left_hand" parent_link="left_wrist" group="left"/>
            <disable_collisions link1="a" link2="b" reason="Never"/>
            <disable_collisions link1="b" link2="c"/>
          </robot>"#;
        let read = Srdf::read(text).unwrap();
        let hand = EndEffector { name: "left_hand".to_owned(), parent_link: "left_wrist".to_owned() };
        assert_eq!(read.end_effectors, [hand]);
        assert_eq!(read.disabled[0], DisabledPair { links: ["a", "b"].map(str::to_owned), reason: "Never".to_owned() });
        assert_eq!(read.disabled[1].reason, "");
        assert!(Srdf::read("<mujoco/>").is_err() && Srdf::read("<robot>").is_err());
    }
}
