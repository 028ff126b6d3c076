//! Why a URDF text is refused.

use crate::ModelError;

/// Why a URDF text is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum UrdfError {
    /// Far more text, attributes or namespaces than a robot needs.
    #[error(
        "too large for a robot description: at most {text} bytes, {attributes} attributes in an element, {namespaces} \
         namespaces"
    )]
    TooLarge {
        /// Bytes of text.
        text: usize,
        /// Attributes of one element.
        attributes: usize,
        /// Namespaces of the text.
        namespaces: usize,
    },
    /// Not well-formed XML, more than 100 000 nodes, or with a document type definition.
    #[error("URDF: {0}")]
    Xml(#[from] roxmltree::Error),
    /// XML of something else.
    #[error("the outermost element is <{root}>; URDF has <robot>, and xacro must be expanded first")]
    NotRobot {
        /// The outermost element.
        root: String,
    },
    /// An element without a name.
    #[error("the {place}. <{element}> of the robot needs a name of 1 to 256 bytes")]
    Unnamed {
        /// `link` or `joint`.
        element: &'static str,
        /// Its place, from 1.
        place: usize,
    },
    /// Two links or two joints share a name.
    #[error("two {element}s are named `{name}`; give each its own name")]
    Duplicate {
        /// `link` or `joint`.
        element: &'static str,
        /// The name.
        name: String,
    },
    /// A joint lacks what every joint needs.
    #[error("joint `{joint}` needs {what}")]
    Missing {
        /// The joint.
        joint: String,
        /// What it lacks.
        what: &'static str,
    },
    /// A joint connects a link that does not exist.
    #[error("joint `{joint}` connects link `{link}`, which the text does not have")]
    UnknownLink {
        /// The joint.
        joint: String,
        /// The link.
        link: String,
    },
    /// A link hangs on two joints.
    #[error("link `{link}` is the child of the joints `{first}` and `{second}`; only trees have chains")]
    TwoParents {
        /// The link.
        link: String,
        /// A joint.
        first: String,
        /// Another joint.
        second: String,
    },
    /// Following parents leads back.
    #[error("the links form a cycle through `{link}`; only trees have chains")]
    Cycle {
        /// A link of the cycle.
        link: String,
    },
    /// More than one link, or none, hangs on nothing.
    #[error("links without parent: {}; name the `base`", list(.links))]
    Base {
        /// Links without parent.
        links: Vec<String>,
    },
    /// The chain could end at several links.
    #[error("the chain from `{base}` can end at several links; name the `tip`: {}", list(.leaves))]
    Tip {
        /// Where the chain begins.
        base: String,
        /// Links without children.
        leaves: Vec<String>,
    },
    /// The base does not exist.
    #[error("there is no link `{link}` to be the base; links without parent: {}", list(.roots))]
    UnknownBase {
        /// The name.
        link: String,
        /// Links without parent.
        roots: Vec<String>,
    },
    /// The tip does not exist, or does not hang on the base.
    #[error("no chain leads from `{base}` to a link `{tip}`; chains from there end at {}", list(.leaves))]
    UnknownTip {
        /// Where the chain begins.
        base: String,
        /// The name.
        tip: String,
        /// Links without children below the base.
        leaves: Vec<String>,
    },
    /// A joint of the chain that is no axis of a serial arm.
    #[error(
        "joint `{joint}` of the chain is {kind}; only fixed, revolute, continuous and prismatic joints that move by \
         themselves can be controlled"
    )]
    Kind {
        /// The joint.
        joint: String,
        /// Its type, or `mimic`.
        kind: String,
    },
    /// Not as many numbers as needed, not finite, or out of proportion.
    #[error("joint `{joint}`: {field}=\"{text:.40}\" is not {count} number(s) between -1e9 and 1e9")]
    Number {
        /// The joint.
        joint: String,
        /// The attribute.
        field: &'static str,
        /// What stands there.
        text: String,
        /// How many numbers belong there.
        count: usize,
    },
    /// An axis of length zero.
    #[error("joint `{joint}`: the axis has length zero; give its direction")]
    Axis {
        /// The joint.
        joint: String,
    },
    /// The chain is no robot.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// The first names of a list, each in quotes.
fn list(names: &[String]) -> String {
    const SHOWN: usize = 50;
    let shown: Vec<String> = names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect();
    match names.len().saturating_sub(SHOWN) {
        0 if names.is_empty() => "none".to_owned(),
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
