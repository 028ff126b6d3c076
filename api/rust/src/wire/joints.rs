//! One number per joint, in the robot's order or by name.

use std::fmt;

use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// One number per joint.
#[derive(Debug, Clone, PartialEq)]
pub enum JointVector {
    /// In the robot's joint order.
    Ordered(Vec<f64>),
    /// By joint name, in any order, each once.
    Named(Vec<(String, f64)>),
}

impl From<Vec<f64>> for JointVector {
    fn from(values: Vec<f64>) -> Self {
        Self::Ordered(values)
    }
}

impl Serialize for JointVector {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Ordered(values) => values.serialize(serializer),
            Self::Named(values) => serializer.collect_map(values.iter().map(|(name, value)| (name, value))),
        }
    }
}

impl<'de> Deserialize<'de> for JointVector {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(JointVectorVisitor)
    }
}

struct JointVectorVisitor;

impl<'de> Visitor<'de> for JointVectorVisitor {
    type Value = JointVector;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a list of numbers in joint order or an object of numbers by joint name")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<JointVector, A::Error> {
        let mut values = Vec::with_capacity(list.size_hint().unwrap_or(8).min(64));
        while let Some(value) = list.next_element()? {
            values.push(value);
        }
        Ok(JointVector::Ordered(values))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<JointVector, A::Error> {
        let mut values: Vec<(String, f64)> = Vec::new();
        while let Some(entry) = map.next_entry()? {
            values.push(entry);
        }
        match repeated(&values) {
            Some(name) => Err(Error::custom(format!("joint `{name}` is given twice"))),
            None => Ok(JointVector::Named(values)),
        }
    }
}

/// A name that stands twice. Sorted, not compared pair by pair: a body has room for a hundred thousand names.
fn repeated(values: &[(String, f64)]) -> Option<&str> {
    let mut names: Vec<&str> = values.iter().map(|(name, _)| name.as_str()).collect();
    names.sort_unstable();
    names.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_and_objects_are_read_and_written_back() {
        for text in ["[1.0,2.0]", r#"{"j2":2.0,"j1":1.0}"#] {
            let vector: JointVector = serde_json::from_str(text).unwrap();
            assert_eq!(serde_json::to_string(&vector).unwrap(), text);
        }
    }

    #[test]
    fn a_joint_given_twice_and_other_types_are_refused() {
        let refusal = |text| serde_json::from_str::<JointVector>(text).unwrap_err().to_string();
        assert!(refusal(r#"{"j1":1.0,"j1":2.0}"#).contains("`j1` is given twice"));
        assert!(refusal("3.0").contains("a list of numbers in joint order"));
    }
}
