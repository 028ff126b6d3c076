//! `revprio payload`

use std::path::{Path, PathBuf};

use revprio_api::wire::{
    JointVector, PayloadAnswer, PayloadReading, PayloadRequest, Pose, Wrench, WrenchConvention, WrenchFrame,
};

use super::error::CliError;
use super::finite::finite;
use super::output::print_text;
use super::service_choice::server_address;
use super::target::Target;

/// The columns of a wrench in a table.
const WRENCH: [&str; 6] = ["force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"];

/// The columns of gravity in a table.
const GRAVITY: [&str; 3] = ["gravity_x", "gravity_y", "gravity_z"];

/// A table needs --robot if it has the postures. The options replace fields of a request in JSON.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// Readings at rest: a request in JSON as for POST /v1/payload, or a table in CSV with the columns force_x … torque_z, and one per
    /// joint or gravity_x, gravity_y, gravity_z (m/s², sensor axes); `-` reads standard input
    file: PathBuf,
    /// Name of the robot whose postures the readings have
    #[arg(long)]
    robot: Option<String>,
    /// Tip before which the sensor is, by its name; the tool if it is left out
    #[arg(long)]
    tip: Option<String>,
    /// Pose of the sensor in the robot's own tool frame, in JSON as in a request:
    /// '{"position": [0, 0, 0.1], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}'
    #[arg(long, value_parser = pose)]
    pose: Option<Pose>,
    /// Acceleration of gravity along the axes of the base, m/s², for an arm that is not mounted upright [default: 0,0,-9.81]
    #[arg(long, value_name = "X,Y,Z", value_parser = three, allow_hyphen_values = true)]
    gravity: Option<[f64; 3]>,
    /// The readings are the wrench on the tool, as most wrist sensors give it
    #[arg(long)]
    on_tool: bool,
    /// The readings are along the axes of the base, not of the sensor
    #[arg(long)]
    base_axes: bool,
    /// Noise of a force reading, rms, N
    #[arg(long, value_parser = finite)]
    force_noise_n: Option<f64>,
    /// Noise of a torque reading, rms, N·m
    #[arg(long, value_parser = finite)]
    torque_noise_nm: Option<f64>,
    /// Service to call, for example http://127.0.0.1:8080, with the token in the file `REVPRIO_TOKEN_FILE` if that is set; if
    /// left out, the command starts its own
    #[arg(long, value_parser = server_address)]
    server: Option<String>,
    /// Print the answer as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(options: &Options) -> Result<(), CliError> {
    let mut request = read(&options.file)?;
    options.replace_fields(&mut request)?;
    let answer = Target::open(options.server.as_deref())?.client.payload(&request)?;
    if options.json {
        let json = serde_json::to_string_pretty(&answer);
        let json = json.map_err(|source| CliError::ParseProblem { path: options.file.clone(), source })?;
        return Ok(print_text(json + "\n")?);
    }
    Ok(print_text(describe(&answer))?)
}

impl Options {
    /// Replaces fields of a request by the options that are given.
    fn replace_fields(&self, request: &mut PayloadRequest) -> Result<(), CliError> {
        let for_postures =
            [("--tip", self.tip.is_some()), ("--pose", self.pose.is_some()), ("--gravity", self.gravity.is_some())];
        if let Some((option, _)) = for_postures.iter().find(|(_, is_given)| *is_given)
            && request.readings.iter().any(|reading| reading.gravity.is_some())
        {
            let detail =
                "the readings have gravity along the axes of the sensor; this option is for readings with postures";
            return Err(CliError::Option { option: (*option).to_owned(), detail: detail.to_owned() });
        }
        request.robot = self.robot.clone().or(request.robot.take());
        request.tip = self.tip.clone().or(request.tip.take());
        request.pose = self.pose.or(request.pose);
        request.gravity = self.gravity.unwrap_or(request.gravity);
        if self.on_tool {
            request.wrench_convention = WrenchConvention::OnTool;
        }
        if self.base_axes {
            request.wrench_frame = WrenchFrame::Base;
        }
        request.force_noise_n = self.force_noise_n.unwrap_or(request.force_noise_n);
        request.torque_noise_nm = self.torque_noise_nm.unwrap_or(request.torque_noise_nm);
        Ok(())
    }
}

/// Reads a pose in JSON.
fn pose(text: &str) -> Result<Pose, String> {
    let example = r#"give {"position": [0, 0, 0.1], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}"#;
    serde_json::from_str(text).map_err(|_| example.to_owned())
}

/// Reads three numbers between commas.
fn three(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|number| number.trim().parse().ok().filter(|number: &f64| number.is_finite())).collect();
    let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or_else(|| "give three numbers with commas between them".to_owned())
}

fn read(path: &Path) -> Result<PayloadRequest, CliError> {
    let text =
        if path == Path::new("-") { std::io::read_to_string(std::io::stdin()) } else { std::fs::read_to_string(path) };
    let text = text.map_err(|source| CliError::ReadProblem { path: path.to_owned(), source })?;
    if !text.trim_start().starts_with('{') {
        return table(&text).map_err(|message| CliError::PayloadTable { path: path.to_owned(), message });
    }
    serde_json::from_str(&text).map_err(|source| CliError::ParseProblem { path: path.to_owned(), source })
}

/// Reads a table. Columns that are neither wrench nor gravity are joints.
fn table(text: &str) -> Result<PayloadRequest, String> {
    let text = text.trim_start_matches('\u{feff}');
    if text.trim().is_empty() {
        return Err("the file is empty".to_owned());
    }
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
    let names: Vec<String> = reader.headers().map_err(|error| error.to_string())?.iter().map(str::to_owned).collect();
    let has_gravity = check_columns(&names)?;
    let mut readings = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| in_words(&error))?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut row = Vec::with_capacity(names.len());
        for (name, cell) in names.iter().zip(&record) {
            let value = cell.parse::<f64>().ok().filter(|value| value.is_finite());
            row.push((
                name.as_str(),
                value.ok_or_else(|| format!("line {line}: `{cell}` in `{name}` is not a number"))?,
            ));
        }
        readings.push(reading(&row, has_gravity));
    }
    // The other fields have their defaults.
    let empty: PayloadRequest = serde_json::from_str(r#"{"readings": []}"#).map_err(|error| error.to_string())?;
    Ok(PayloadRequest { readings, ..empty })
}

/// Returns whether the table has gravity, if it has what a reading needs.
fn check_columns(names: &[String]) -> Result<bool, String> {
    let has = |name: &&&str| names.iter().any(|column| column == **name);
    if let Some(name) = WRENCH.iter().find(|name| !has(name)) {
        return Err(format!(
            "the column `{name}` is missing; the first line names the columns, separated by commas: {}",
            names.join(", ")
        ));
    }
    if let Some(name) = names.iter().enumerate().find_map(|(k, name)| names[..k].contains(name).then_some(name)) {
        return Err(format!("the column `{name}` is there twice"));
    }
    let given = GRAVITY.iter().filter(has).count();
    if given != 0 && given != GRAVITY.len() {
        return Err("give all of gravity_x, gravity_y and gravity_z, or none".to_owned());
    }
    let other = names.iter().find(|name| !WRENCH.contains(&name.as_str()) && !GRAVITY.contains(&name.as_str()));
    match other.filter(|_| given > 0) {
        Some(name) => Err(format!("the column `{name}` is too much: gravity is given, so there is no posture")),
        None => Ok(given > 0),
    }
}

/// Says what is wrong with a line of a table.
fn in_words(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            format!("line {line}: {len} cells for {expected_len} columns")
        }
        _ => error.to_string(),
    }
}

/// Returns the reading of a row that has all columns of a wrench.
fn reading(row: &[(&str, f64)], has_gravity: bool) -> PayloadReading {
    let value = |name: &str| row.iter().find(|(column, _)| *column == name).map_or(f64::NAN, |(_, value)| *value);
    let [fx, fy, fz, tx, ty, tz] = WRENCH.map(value);
    let joints = row.iter().filter(|(name, _)| !WRENCH.contains(name) && !GRAVITY.contains(name));
    let joints: Vec<(String, f64)> = joints.map(|(name, value)| ((*name).to_owned(), *value)).collect();
    PayloadReading {
        joint_position: (!has_gravity).then_some(JointVector::Named(joints)),
        gravity: has_gravity.then(|| GRAVITY.map(value)),
        wrench: Wrench { force: [fx, fy, fz], torque: [tx, ty, tz] },
    }
}

fn describe(answer: &PayloadAnswer) -> String {
    let PayloadAnswer { bias, payload, mass_uncertainty_kg, force_residual_n, torque_residual_nm, .. } = answer;
    let listed = |numbers: [f64; 3], digits: i32| {
        // The sum has no negative zero.
        let scale = 10.0_f64.powi(digits);
        let [x, y, z] = numbers.map(|number| (number * scale).round() / scale + 0.0);
        let digits = usize::try_from(digits).unwrap_or(0);
        format!("{x:.digits$}, {y:.digits$}, {z:.digits$}")
    };
    let center = match answer.center_of_mass_uncertainty_m {
        Some(sigma) => format!("{} mm ± {:.1}", listed(payload.center_of_mass.map(|c| 1e3 * c), 1), 1e3 * sigma),
        None => "unknown: no payload".to_owned(),
    };
    let axes = if answer.axes_verified {
        "verified: no other sign or order of the axes fits"
    } else {
        "not verified: the payload is too light for the noise, or the postures are too similar"
    };
    format!(
        "mass              {:.4} kg ± {mass_uncertainty_kg:.4}\ncentre of mass    {center}\nbias              {} N\n\
         {:18}{} N·m\nresidual, rms     {force_residual_n:.3} N, {torque_residual_nm:.4} N·m\n\
         postures          {} readings, condition {:.2} (1 at best, above 8 refused)\nsign and axes     {axes}\n",
        payload.mass_kg,
        listed(bias.force, 3),
        "",
        listed(bias.torque, 4),
        answer.readings,
        answer.condition,
    )
}
