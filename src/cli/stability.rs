//! `revprio stability`

use revprio_api::ClientError;
use revprio_api::wire::{EnvironmentAxis, StabilityAnswer, StabilityRequest};
use revprio_core::controller::MAX_DELAY_PERIODS;
use revprio_lab::number::{plain, significant};

use super::error::CliError;
use super::finite::finite;
use super::output::print_text;
use super::range::Range;
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
    /// First-order lag of the arm's velocity loop, s, up to 10
    #[arg(long, default_value_t = 0.0, value_parser = finite)]
    lag_s: f64,
    /// Delay of a command, whole periods
    #[arg(long, default_value_t = 0)]
    delay_periods: usize,
    /// The states have no measured velocity, so that the law damps the commanded velocity
    #[arg(long)]
    velocity_not_measured: bool,
    /// Service to call, for example http://127.0.0.1:8080, with the token in the file `REVPRIO_TOKEN_FILE` if that is set; if
    /// left out, the command starts its own
    #[arg(long, value_parser = server_address)]
    server: Option<String>,
}

/// Lag of a velocity loop. That of an arm is 5 to 50 ms.
const LAG: Range = Range { option: "--lag-s", unit: "s", lowest: 0.0, highest: 10.0 };

pub fn run(options: &Options) -> Result<(), CliError> {
    LAG.check(options.lag_s)?;
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
    Ok(print_text(describe(&request, &answer))?)
}

/// Names the option that a refused field comes from: both have the same words.
fn named(error: ClientError) -> CliError {
    let ClientError::Refused { problem, .. } = &error else { return error.into() };
    let Some(field) = problem.pointer.as_deref().and_then(|pointer| pointer.strip_prefix('/')) else {
        return error.into();
    };
    CliError::Option { option: format!("--{}", field.replace(['/', '_'], "-")), detail: problem.detail.clone() }
}

/// Lags and dampings below this part of the scale of the loop are zero up to rounding.
const ROUNDING: f64 = 1e-9;

fn describe(request: &StabilityRequest, answer: &StabilityAnswer) -> String {
    let stable = if answer.stable { "stable" } else { "unstable" };
    format!(
        "{stable}, spectral radius {}\nlargest lag           {}\nlargest delay         {}\nsmallest damping B_d  {}\n\
         largest damping B_d   {}\nloop                  period {} ms, lag {} ms, delay {}\n",
        spectral_radius(answer.spectral_radius),
        largest_lag(request, answer),
        largest_delay(request, answer),
        smallest_damping(request, answer),
        answer.largest_damping.map_or_else(|| "none".to_owned(), |damping| format!("below {}", plain(damping))),
        plain(1e3 * request.period_s),
        plain(1e3 * request.lag_s),
        periods(request.delay_periods),
    )
}

/// Formats a spectral radius. Next to 1, its distance from 1 tells whether the loop is stable.
fn spectral_radius(radius: f64) -> String {
    let rounded = format!("{radius:.6}");
    match radius - 1.0 {
        0.0 => "1".to_owned(),
        distance if rounded == "1.000000" => {
            format!("1 {} {}", if distance < 0.0 { "-" } else { "+" }, significant(distance.abs(), 2))
        }
        _ => rounded,
    }
}

fn largest_lag(request: &StabilityRequest, answer: &StabilityAnswer) -> String {
    let lag = answer.largest_lag_s.filter(|lag| *lag > ROUNDING * request.period_s);
    match lag {
        _ if answer.stable_at_any_lag => "any".to_owned(),
        Some(lag) if !answer.stable && lag > request.lag_s => {
            format!("{} ms, but shorter lags are unstable", plain(1e3 * lag))
        }
        Some(lag) => format!("{} ms", plain(1e3 * lag)),
        None => "none".to_owned(),
    }
}

fn largest_delay(request: &StabilityRequest, answer: &StabilityAnswer) -> String {
    // Rounding can make the loop stable in the search for the margin alone.
    let is_stable = |delay: &usize| answer.stable || *delay != request.delay_periods;
    match answer.largest_delay_periods.filter(is_stable) {
        Some(delay) if delay >= MAX_DELAY_PERIODS => format!("{delay} periods or more"),
        Some(delay) => periods(delay),
        None => "none".to_owned(),
    }
}

fn periods(number: usize) -> String {
    if number == 1 { "1 period".to_owned() } else { format!("{number} periods") }
}

/// Formats the smallest damping. A loop without any damping swings without end, so that 0 is stable only if the environment damps.
fn smallest_damping(request: &StabilityRequest, answer: &StabilityAnswer) -> String {
    match answer.smallest_damping {
        None => "no value is stable".to_owned(),
        Some(0.0) if request.environment.damping > 0.0 => "0".to_owned(),
        Some(damping) if damping <= ROUNDING * request.inertia / request.period_s => "above 0".to_owned(),
        Some(damping) => format!("above {}", plain(damping)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spectral_radius_next_to_1_tells_its_side() {
        for (radius, text) in [
            (0.994_987_4, "0.994987"),
            (1.0, "1"),
            (1.0 - 1e-8, "1 - 1.0e-8"),
            (1.0 + 2e-7, "1 + 2.0e-7"),
            (1.000_009, "1.000009"),
        ] {
            assert_eq!(spectral_radius(radius), text);
        }
    }
}
