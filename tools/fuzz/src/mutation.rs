//! Mutations that keep an input well-formed, so that they pass the parsers.
//!
//! The fuzzer mutates bytes too. Most of those inputs are refused at once.

use std::sync::OnceLock;

use fastrand::Rng;
use serde_json::{Map, Value, json};

use crate::Target;
use crate::seeds::seeds;
use crate::target::split_line;

/// Numbers at which code behaves differently.
const NUMBERS: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    2.0,
    1e-3,
    1e-6,
    1e-9,
    1e-12,
    1e-16,
    1e-160,
    1e-300,
    5e-324,
    1e3,
    1e6,
    1e9,
    -1e9,
    1e16,
    1e150,
    1e308,
    1.797_693_134_862_315_7e308,
    std::f64::consts::FRAC_PI_2,
    std::f64::consts::PI,
];

/// Maximum number of mutations at a time.
const MAX_MUTATIONS: usize = 4;

/// Maximum length of a list after its items are repeated.
const MAX_ITEMS: usize = 130;

/// Returns a mutated input, or `None` if the input has no structure to keep.
pub fn mutate(target: Target, input: &[u8], random: &mut Rng) -> Option<Vec<u8>> {
    match target {
        Target::Json => after_first_line(input, |body| mutate_json(body, random)),
        Target::MessagePack => after_first_line(input, |body| {
            let mut value: Value = rmp_serde::from_slice(body).ok()?;
            mutate_value(&mut value, random);
            rmp_serde::to_vec(&value).ok()
        }),
        Target::Stream if input.starts_with(b"json\n") => {
            after_first_line(input, |messages| mutate_lines(messages, random))
        }
        Target::Stability => mutate_json(input, random),
        Target::Controller => mutate_lines(input, random),
        Target::Stream | Target::Urdf => None,
    }
}

fn after_first_line(input: &[u8], mutate: impl FnOnce(&[u8]) -> Option<Vec<u8>>) -> Option<Vec<u8>> {
    let (line, rest) = split_line(input)?;
    Some([line, b"\n", &mutate(rest)?].concat())
}

/// Mutates one of several lines of JSON, or their order.
fn mutate_lines(text: &[u8], random: &mut Rng) -> Option<Vec<u8>> {
    let mut lines: Vec<Vec<u8>> = text.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    let index = random.usize(..lines.len());
    match random.u8(..8) {
        0 if lines.len() > 1 => drop(lines.remove(index)),
        1 if lines.len() < 16 => lines.push(lines[index].clone()),
        _ => lines[index] = mutate_json(&lines[index], random)?,
    }
    Some(lines.join(&b"\n"[..]))
}

fn mutate_json(body: &[u8], random: &mut Rng) -> Option<Vec<u8>> {
    let mut value: Value = serde_json::from_slice(body).ok()?;
    mutate_value(&mut value, random);
    serde_json::to_vec(&value).ok()
}

fn mutate_value(value: &mut Value, random: &mut Rng) {
    for _ in 0..random.usize(1..=MAX_MUTATIONS) {
        let index = random.usize(..size(value));
        mutate_part(nth_mut(value, &mut { index }), random);
    }
}

/// Number of values inside a value, itself included.
fn size(value: &Value) -> usize {
    1 + match value {
        Value::Array(items) => items.iter().map(size).sum(),
        Value::Object(fields) => fields.values().map(size).sum(),
        _ => 0,
    }
}

/// Returns the value with this index, in the order of the text.
fn nth_mut<'a>(value: &'a mut Value, index: &mut usize) -> &'a mut Value {
    if *index == 0 {
        return value;
    }
    *index -= 1;
    let parts: Vec<&mut Value> = match value {
        Value::Array(items) => items.iter_mut().collect(),
        Value::Object(fields) => fields.values_mut().collect(),
        _ => Vec::new(),
    };
    for part in parts {
        let inside = size(part);
        if *index < inside {
            return nth_mut(part, index);
        }
        *index -= inside;
    }
    unreachable!("the index is below the size")
}

fn mutate_part(value: &mut Value, random: &mut Rng) {
    if random.u8(..16) == 0 {
        *value = known_value(random);
        return;
    }
    match value {
        Value::Null => *value = known_value(random),
        Value::Bool(flag) => *flag = !*flag,
        Value::Number(number) => {
            let number = number.as_f64().unwrap_or_default();
            *value = mutate_number(number, random);
        }
        Value::String(text) => mutate_text(text, random),
        Value::Array(items) => mutate_list(items, random),
        Value::Object(fields) => mutate_object(fields, random),
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the number is whole and below 1e15")]
fn mutate_number(number: f64, random: &mut Rng) -> Value {
    let changed = match random.u8(..8) {
        0 => NUMBERS[random.usize(..NUMBERS.len())],
        1 => -number,
        2 => number * 10_f64.powi(random.i32(-12..=12)),
        3 => number * (1.0 + random.f64() * 1e-13),
        4 => number + 2.0 * random.f64() - 1.0,
        5 => return json!(random.u64(..)),
        6 => return json!(random.u32(..200)),
        _ => number * 2.0 * random.f64(),
    };
    // Whole numbers stay whole, because indices and counters must be.
    if changed.fract() == 0.0 && changed.abs() < 1e15 { json!(changed as i64) } else { json!(changed) }
}

fn mutate_text(text: &mut String, random: &mut Rng) {
    match random.u8(..8) {
        0 => text.clear(),
        1 => *text = text.repeat(random.usize(2..20)),
        2 => text.push(random.char(..)),
        _ => {
            let words = &pool().words;
            text.clone_from(&words[random.usize(..words.len())]);
        }
    }
}

fn mutate_list(items: &mut Vec<Value>, random: &mut Rng) {
    if items.is_empty() {
        items.push(known_value(random));
        return;
    }
    let (index, other) = (random.usize(..items.len()), random.usize(..items.len()));
    match random.u8(..6) {
        0 => drop(items.remove(index)),
        1 => items.insert(index, items[other].clone()),
        2 => items.swap(index, other),
        3 => items[index] = items[other].clone(),
        4 => {
            let count = random.usize(2..8) * items.len();
            let item = items[index].clone();
            items.resize(count.min(MAX_ITEMS).max(items.len()), item);
        }
        _ => random.shuffle(items),
    }
}

fn mutate_object(fields: &mut Map<String, Value>, random: &mut Rng) {
    let key = fields.keys().nth(random.usize(..fields.len().max(1))).cloned();
    match (random.u8(..4), key) {
        (0, Some(key)) => drop(fields.remove(&key)),
        (1, Some(key)) => {
            let value = fields.remove(&key).unwrap_or_default();
            let names = &pool().names;
            fields.insert(names[random.usize(..names.len())].clone(), value);
        }
        _ => {
            let known = &pool().fields;
            let (key, value) = &known[random.usize(..known.len())];
            fields.insert(key.clone(), value.clone());
        }
    }
}

fn known_value(random: &mut Rng) -> Value {
    let fields = &pool().fields;
    match random.u8(..8) {
        0 => Value::Null,
        1 => json!(NUMBERS[random.usize(..NUMBERS.len())]),
        _ => fields[random.usize(..fields.len())].1.clone(),
    }
}

/// Names of all fields and words.
const OPENAPI: &str = include_str!("../../../api/openapi.json");

/// Fields and texts of all seeds.
#[derive(Default)]
struct Pool {
    /// Names of fields with a value.
    fields: Vec<(String, Value)>,
    /// Names of fields, those of the interface included.
    names: Vec<String>,
    /// Texts, those of the interface included.
    words: Vec<String>,
}

fn pool() -> &'static Pool {
    static POOL: OnceLock<Pool> = OnceLock::new();
    POOL.get_or_init(|| {
        let mut pool = Pool::default();
        for seed in [Target::Json, Target::Controller].into_iter().flat_map(seeds) {
            let lines = seed.split(|byte| *byte == b'\n');
            lines.filter_map(|line| serde_json::from_slice(line).ok()).for_each(|value| pool.add(&value));
        }
        pool.names = pool.fields.iter().map(|(name, _)| name.clone()).collect();
        pool.add_schema(&serde_json::from_str(OPENAPI).unwrap_or_default());
        pool
    })
}

impl Pool {
    /// Adds the names of all properties and the words of all enumerations.
    fn add_schema(&mut self, schema: &Value) {
        let Value::Object(entries) = schema else {
            schema.as_array().into_iter().flatten().for_each(|item| self.add_schema(item));
            return;
        };
        for (key, value) in entries {
            match (key.as_str(), value) {
                ("properties", Value::Object(properties)) => self.names.extend(properties.keys().cloned()),
                ("enum", Value::Array(words)) => {
                    self.words.extend(words.iter().filter_map(Value::as_str).map(str::to_owned));
                }
                _ => {}
            }
            self.add_schema(value);
        }
    }

    fn add(&mut self, value: &Value) {
        match value {
            Value::String(word) if !self.words.contains(word) => self.words.push(word.clone()),
            Value::Array(items) => items.iter().for_each(|item| self.add(item)),
            Value::Object(fields) => {
                for (key, value) in fields {
                    let field = (key.clone(), value.clone());
                    if !self.fields.contains(&field) {
                        self.fields.push(field);
                    }
                    self.add(value);
                }
            }
            _ => {}
        }
    }
}
