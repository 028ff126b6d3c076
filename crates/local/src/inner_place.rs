//! The place of a mistake inside an object whose `kind` decides its fields.
//!
//! serde reads such an object as a whole before it knows the kind, and then forgets where a mistake was. Without the field that is wrong,
//! the body has another mistake or none: that tells the field.

use revprio_api::wire::Object;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::error::escape_pointer;

/// Maximum size of a body that is searched, bytes, and how often it is read again. The thread of the requests does that, so both are small.
const MAX_BYTES: usize = 4 << 10;
const MAX_READS: usize = 24;

/// The field that decides the other fields. Without it there is always another mistake.
const KIND: &str = "kind";

/// Returns the path from an object, the place (a pointer) that serde knows, to the innermost field that is wrong; `None`: it is the object.
pub fn inner_place<T: DeserializeOwned>(bytes: &[u8], place: &str) -> Option<String> {
    if bytes.len() > MAX_BYTES {
        return None;
    }
    let body: Value = serde_json::from_slice(bytes).ok()?;
    let first = mistake::<T>(body.clone())?;
    let (mut found, mut reads) = (place.to_owned(), 0);
    while let Some(Value::Object(fields)) = body.pointer(&found) {
        if names_field_of(&first, fields) {
            break;
        }
        let mut is_wrong = |name: &str| {
            reads += 1;
            reads <= MAX_READS && mistake::<T>(without(&body, &found, name)).as_ref() != Some(&first)
        };
        let of_kind = fields.contains_key(KIND) && first.starts_with("unknown variant ");
        let names = fields.keys().map(String::as_str).filter(|name| *name != KIND);
        let Some(name) = names.chain(of_kind.then_some(KIND)).find(|name| is_wrong(name)) else { break };
        found = format!("{found}/{}", escape_pointer(name));
    }
    found.strip_prefix(place)?.strip_prefix('/').map(str::to_owned)
}

fn mistake<T: DeserializeOwned>(body: Value) -> Option<String> {
    serde_json::from_value::<Object<T>>(body).err().map(|error| error.to_string())
}

/// Returns whether a mistake is a field that these fields lack, or one of them that nothing knows.
fn names_field_of(mistake: &str, fields: &Map<String, Value>) -> bool {
    let named = |start| mistake.strip_prefix(start)?.split('`').next();
    named("missing field `").is_some_and(|name| !fields.contains_key(name))
        || named("unknown field `").is_some_and(|name| fields.contains_key(name))
}

/// Returns a body without a field of an object in it.
fn without(body: &Value, place: &str, name: &str) -> Value {
    let mut body = body.clone();
    body.pointer_mut(place).and_then(Value::as_object_mut).and_then(|fields| fields.remove(name));
    body
}

#[cfg(test)]
mod tests {
    use revprio_api::wire::Controller;
    use serde_json::json;

    use crate::json::read;

    #[test]
    fn a_mistake_inside_a_law_is_told_with_its_field() {
        let detail = |law| {
            let task = json!({"name": "h", "axes": ["x"], "law": law});
            let body = json!({"robot": "panda", "period_s": 0.004, "tasks": [task]});
            let error = read::<Controller>(body.to_string().as_bytes()).unwrap_err().to_string();
            error.strip_prefix("/tasks/0/law: ").unwrap().split(" at line").next().unwrap().to_owned()
        };
        let force = |force| detail(json!({"kind": "contact", "target_force": force}));
        assert_eq!(force(json!(-15)), "in `target_force`: give an object, not -15");
        assert_eq!(force(json!({"value": -15})), "in `target_force`: the field `kind` is missing");
        assert!(
            force(json!({"kind": "constant", "val": -15})).starts_with("in `target_force`: there is no field `val`")
        );
        let unknown = force(json!({"kind": "const", "value": -15}));
        assert!(unknown.starts_with("in `target_force/kind`: there is no value `const`"), "{unknown}");
        let orientation = json!({"w": 1, "x": 0, "y": 0, "z": 0});
        let pose = json!({"position": [1, 2], "orientation": orientation});
        let short = detail(json!({"kind": "pose", "gain": 2, "target_pose": pose}));
        assert_eq!(short, "in `target_pose/position`: give a list of 3 entries, not of 2");
        assert!(detail(json!({"kind": "pose", "gain": "2"})).starts_with("in `gain`: "));
        assert_eq!(detail(json!({"kind": "pose"})), "the field `gain` is missing");
        assert_eq!(detail(json!({"gain": 2})), "the field `kind` is missing");
        assert!(detail(json!({"kind": "pose", "gian": 2})).starts_with("there is no field `gian`"));
    }
}
