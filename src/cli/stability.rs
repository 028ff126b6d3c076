//! `revprio stability`

use revprio_api::ClientError;
use revprio_api::wire::{EnvironmentAxis, StabilityAnswer, StabilityRequest};

use super::error::CliError;
use super::finite::finite;
use super::output::print_text;
use super::service_choice::server_address;
use super::target::Target;

/// Linear axes in kg, N·s/m and N/m, angular ones in kg·m², N·m·s/rad and N·m/rad.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Options {
    /// Inertia `M_d` of the law, kg or kg·m²
    #[arg(long, value_parser = finite)]
    inertia: f64,
    /// Damping `B_d` of the law, N·s/m or N·m·s/rad
    #[arg(long, value_parser = finite)]
    damping: f64,
    /// Stiffness `K_d` of the law, N/m or N·m/rad; 0 for a force law
    #[arg(long, default_value_t = 0.0, value_parser = finite)]
    stiffness: f64,
    /// Stiffness `K_e` of the environment, N/m or N·m/rad
    #[arg(long, value_parser = finite)]
    environment_stiffness: f64,
    /// Damping `B_e` of the environment, N·s/m or N·m·s/rad
    #[arg(long, default_value_t = 0.0, value_parser = finite)]
    environment_damping: f64,
    /// Inertia `M_e` of the environment, kg or kg·m²
    #[arg(long, default_value_t = 0.0, value_parser = finite)]
    environment_inertia: f64,
    /// Control period, s
    #[arg(long, default_value_t = 0.001, value_parser = finite)]
    period_s: f64,
    /// First-order lag of the arm's velocity loop, s
    #[arg(long, default_value_t = 0.0, value_parser = finite)]
    lag_s: f64,
    /// Delay of a command, whole periods
    #[arg(long, default_value_t = 0)]
    delay_periods: usize,
    /// The states have no measured velocity, so that the law damps the commanded velocity
    #[arg(long)]
    velocity_not_measured: bool,
    /// Service to call, for example http://127.0.0.1:8080; if left out, the command starts its own
    #[arg(long, value_parser = server_address)]
    server: Option<String>,
}

pub fn run(options: &Options) -> Result<(), CliError> {
    let request = StabilityRequest {
        inertia: options.inertia,
        damping: options.damping,
        stiffness: options.stiffness,
        environment: EnvironmentAxis {
            stiffness: options.environment_stiffness,
            damping: options.environment_damping,
            inertia: options.environment_inertia,
        },
        period_s: options.period_s,
        lag_s: options.lag_s,
        delay_periods: options.delay_periods,
        velocity_measured: !options.velocity_not_measured,
    };
    let answer = Target::open(options.server.as_deref())?.client.stability(&request).map_err(named)?;
    Ok(print_text(describe(&answer))?)
}

/// Names the option that a refused field comes from: both have the same words.
fn named(error: ClientError) -> CliError {
    let ClientError::Refused { problem, .. } = &error else { return error.into() };
    let Some(field) = problem.pointer.as_deref().and_then(|pointer| pointer.strip_prefix('/')) else {
        return error.into();
    };
    CliError::Option { option: format!("--{}", field.replace(['/', '_'], "-")), detail: problem.detail.clone() }
}

fn describe(answer: &StabilityAnswer) -> String {
    let or_none = |value: Option<String>, none: &str| value.unwrap_or_else(|| none.to_owned());
    let largest = answer.largest_lag_s.map(|lag| format!("{:.4} ms", 1e3 * lag));
    let lag = or_none(largest, if answer.stable_at_any_lag { "any" } else { "none" });
    format!(
        "{}, spectral radius {:.6}\nlargest lag           {lag}\nlargest delay         {}\nsmallest damping B_d  {}\n\
         largest damping B_d   {}\n",
        if answer.stable { "stable" } else { "unstable" },
        answer.spectral_radius,
        or_none(answer.largest_delay_periods.map(|periods| format!("{periods} period(s)")), "none"),
        or_none(answer.smallest_damping.map(|damping| format!("above {damping:.4}")), "no value is stable"),
        or_none(answer.largest_damping.map(|damping| format!("below {damping:.4}")), "none"),
    )
}
