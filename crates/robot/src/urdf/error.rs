//! The errors of reading URDF.

use crate::ModelError;

/// Why a URDF text is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum UrdfError {
    /// The text exceeds a bound on its size.
    #[error(
        "too large for a robot description: at most {text} bytes, {attributes} attributes in an element, {namespaces} \
         namespaces"
    )]
    TooLarge {
        /// Maximum number of bytes.
        text: usize,
        /// Maximum number of attributes of one element.
        attributes: usize,
        /// Maximum number of namespaces.
        namespaces: usize,
    },
    /// The text is not well-formed XML, has more than 100 000 nodes, or has a document type definition.
    #[error("URDF: {0}")]
    Xml(#[from] roxmltree::Error),
    /// The root element is not `<robot>`.
    #[error("the outermost element is <{root}>, not <robot>; this is no URDF text")]
    NotRobot {
        /// The root element.
        root: String,
    },
    /// The text is a MuJoCo model.
    #[error("this is a MuJoCo model (MJCF), not URDF; convert it in Python: `revprio.read_mjcf(FILE)` returns URDF")]
    Mjcf,
    /// The text is not expanded.
    #[error("the text contains <xacro:{element}>; expand it first: `xacro FILE > my_arm.urdf`")]
    Xacro {
        /// The first element of xacro.
        element: String,
    },
    /// A link or joint has no name, or a name that is too long.
    #[error("<{element}> number {place} of the robot needs a name of 1 to 256 bytes")]
    Unnamed {
        /// `link` or `joint`.
        element: &'static str,
        /// Its position among the elements of this kind, from 1.
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
    /// A joint lacks a required part.
    #[error("joint `{joint}` needs {what}")]
    Missing {
        /// The joint.
        joint: String,
        /// The missing part.
        what: &'static str,
    },
    /// A joint connects a link that does not exist.
    #[error("joint `{joint}` connects link `{link}`, which does not exist")]
    UnknownLink {
        /// The joint.
        joint: String,
        /// The link.
        link: String,
    },
    /// The base is not named, and several links or none have no parent.
    #[error("links without parent: {}; name the `base`", list(.links))]
    Base {
        /// Links without parent.
        links: Vec<String>,
    },
    /// The tip is not named, and several links have no children.
    #[error("the chain from `{base}` can end at several links; name the `tip`: {}", list(.leaves))]
    Tip {
        /// The base link.
        base: String,
        /// Links without children below the base.
        leaves: Vec<String>,
    },
    /// The tip is not named, and the robot has several arms.
    #[error("the robot has {} arms; name the `tip`: {}; or register several as `tips`", .tips.len(), list(.tips))]
    Arms {
        /// The base link.
        base: String,
        /// The tip of each arm.
        tips: Vec<String>,
    },
    /// There is no link with the name of the base.
    #[error("the base link `{link}` does not exist; links without parent: {}", list(.roots))]
    UnknownBase {
        /// The name of the base.
        link: String,
        /// Links without parent.
        roots: Vec<String>,
    },
    /// There is no link with the name of the tip below the base.
    #[error("no chain leads from `{base}` to a link `{tip}`; chains from there end at {}", list(.leaves))]
    UnknownTip {
        /// The base link.
        base: String,
        /// The name of the tip.
        tip: String,
        /// Links without children below the base.
        leaves: Vec<String>,
    },
    /// A joint of the chain has a type that a serial arm cannot have.
    #[error(
        "joint `{joint}` of the chain is {kind}; a chain has fixed, revolute, continuous and prismatic joints without `mimic`{}",
        remedy_for(.kind)
    )]
    Kind {
        /// The joint.
        joint: String,
        /// Its type, or `mimic`.
        kind: String,
    },
    /// A joint of a tree has a type that it cannot have.
    #[error("joint `{joint}` is {kind}; only fixed, revolute, continuous and prismatic joints are supported{}", remedy_for(.kind))]
    TreeKind {
        /// The joint.
        joint: String,
        /// Its type.
        kind: String,
    },
    /// An attribute has the wrong number of numbers, or one that is not finite or too large.
    #[error("joint `{joint}`: {field}=\"{text:.40}\" is not {count} number(s) between -1e9 and 1e9")]
    Number {
        /// The joint.
        joint: String,
        /// The attribute.
        field: &'static str,
        /// Its text.
        text: String,
        /// The number of numbers that it must have.
        count: usize,
    },
    /// A limit is missing or impossible, for the same reason at one or several joints.
    #[error("joint {}: {cause}; state it in `limits`: {{{}}}", list(.joints), remedies(.joints, .remedy))]
    Limit {
        /// The joints.
        joints: Vec<String>,
        /// What is wrong with the limit.
        cause: String,
        /// The part of `limits` that mends it.
        remedy: &'static str,
    },
    /// An override is about a joint that is no part of the chain or tree.
    #[error("`{field}` has a joint `{joint}`, which is no joint of the chain; its joints are {}", list(.joints))]
    UnknownJoint {
        /// `limits` or `joint_names`.
        field: &'static str,
        /// The joint.
        joint: String,
        /// The joints of the chain.
        joints: Vec<String>,
    },
    /// A new name of a joint is empty or too long.
    #[error("`joint_names`: the new name of joint `{joint}` needs 1 to 256 bytes")]
    JointName {
        /// The joint.
        joint: String,
    },
    /// The axis of a joint has length zero.
    #[error("joint `{joint}`: the axis has length zero; give its direction")]
    Axis {
        /// The joint.
        joint: String,
    },
    /// A `<collision>` element is not a body.
    #[error("link `{link}`: {what}")]
    Body {
        /// The link.
        link: String,
        /// What is wrong with it.
        what: String,
    },
    /// The chain or tree is not a valid robot model.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl UrdfError {
    /// Links that the refused or missing base or tip can be, best first; empty for other errors.
    pub fn candidates(&self) -> &[String] {
        match self {
            Self::Base { links } => links,
            Self::UnknownBase { roots, .. } => roots,
            Self::Tip { leaves, .. } | Self::UnknownTip { leaves, .. } => leaves,
            Self::Arms { tips, .. } => tips,
            _ => &[],
        }
    }
}

/// Maximum number of names that an error lists.
const MAX_SHOWN: usize = 50;

/// Returns the part of `limits` that mends the limits of joints.
fn remedies(joints: &[String], remedy: &str) -> String {
    let each: Vec<String> = joints.iter().take(MAX_SHOWN).map(|joint| format!("\"{joint}\": {{{remedy}}}")).collect();
    each.join(", ")
}

/// Returns the first names of a list, each in backquotes.
/// Returns what to do about a joint of an unsupported type.
fn remedy_for(kind: &str) -> &'static str {
    match kind {
        "mimic" => ". `tips` instead of `tip` reads the tree, with `mimic`",
        "planar" => ". Replace it by two prismatic joints and a continuous one",
        "floating" => ". Replace it by three prismatic and three continuous joints, or fix it",
        "closed_loop" => ". It closes a loop: end the chain before it",
        _ => "",
    }
}

fn list(names: &[String]) -> String {
    let shown: Vec<String> = names.iter().take(MAX_SHOWN).map(|name| format!("`{name}`")).collect();
    match names.len().saturating_sub(MAX_SHOWN) {
        0 if names.is_empty() => "none".to_owned(),
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
