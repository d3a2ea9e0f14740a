//! Runs every bench of the workspace in one go and compares their medians. It judges no number: timing is
//! for people to read.

use std::fmt::Write as _;
use std::path::Path;
use std::time::SystemTime;

use anyhow::{Context as _, Result, bail};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::metadata::Metadata;
use crate::paint::Paint;
use crate::shell;

/// One measured function.
#[derive(Debug)]
struct Measurement {
    group: String,
    function: String,
    median_ns: f64,
}

#[derive(Deserialize)]
struct Benchmark {
    group_id: String,
    #[serde(default)]
    function_id: Option<String>,
    #[serde(default)]
    value_str: Option<String>,
}

#[derive(Deserialize)]
struct Estimates {
    median: Estimate,
}

#[derive(Deserialize)]
struct Estimate {
    point_estimate: f64,
}

/// Runs the benches; the tables come last, so that they stay in sight.
pub(crate) fn run(root: &Path, paint: Paint) -> Result<()> {
    let metadata = Metadata::of_workspace(root)?;
    let mut cargo = shell::cargo();
    cargo.arg("bench").current_dir(root);
    let mut count = 0;
    for package in metadata.members() {
        for bench in package.targets("bench") {
            cargo.args(["--package", &package.name, "--bench", &bench.name]);
            count += 1;
        }
    }
    if count == 0 {
        bail!("no package of the workspace has a bench");
    }
    let results = metadata.target_directory.join("criterion");
    cargo.env("CRITERION_HOME", &results);
    let start = SystemTime::now();
    shell::run(&mut cargo, paint)?;
    let mut measurements = Vec::new();
    collect(&results, start, &mut measurements)?;
    println!("{}", tables(&mut measurements));
    Ok(())
}

/// Reads what the benches left since `start`: older results are of benches that did not run.
fn collect(folder: &Path, start: SystemTime, found: &mut Vec<Measurement>) -> Result<()> {
    let reading = || format!("cannot read {}", folder.display());
    if !folder.is_dir() {
        return Ok(());
    }
    let estimates = folder.join("estimates.json");
    if folder.ends_with("new") && estimates.is_file() {
        let written = std::fs::metadata(&estimates)
            .and_then(|file| file.modified())
            .with_context(reading)?;
        if written >= start {
            let benchmark: Benchmark = read(&folder.join("benchmark.json"))?;
            let Estimates { median } = read(&estimates)?;
            found.push(benchmark.measured(median.point_estimate));
        }
        return Ok(());
    }
    for entry in std::fs::read_dir(folder).with_context(reading)? {
        collect(&entry.with_context(reading)?.path(), start, found)?;
    }
    Ok(())
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    serde_json::from_str(&text).with_context(|| format!("{} has an unknown form", path.display()))
}

impl Benchmark {
    fn measured(self, median_ns: f64) -> Measurement {
        let parts: Vec<String> = self.function_id.into_iter().chain(self.value_str).collect();
        let function = if parts.is_empty() {
            self.group_id.clone()
        } else {
            parts.join("/")
        };
        Measurement {
            group: self.group_id,
            function,
            median_ns,
        }
    }
}

/// A table a group, the quickest first, with what the others take of its time; then those of no group.
fn tables(measurements: &mut [Measurement]) -> String {
    measurements.sort_by(|a, b| a.group.cmp(&b.group).then(a.median_ns.total_cmp(&b.median_ns)));
    let width = measurements
        .iter()
        .map(|it| it.function.chars().count())
        .max()
        .unwrap_or_default();
    let mut text = String::new();
    let (alone, compared): (Vec<_>, Vec<_>) = measurements
        .chunk_by(|a, b| a.group == b.group)
        .partition(|group| group.len() == 1);
    for group in compared {
        let _ = writeln!(text, "\n{}", group[0].group);
        for Measurement {
            function, median_ns, ..
        } in group
        {
            let (time, ratio) = (time(*median_ns), median_ns / group[0].median_ns);
            let _ = writeln!(text, "  {function:width$}  {time:>10}  {ratio:>8.2} x");
        }
    }
    if !alone.is_empty() {
        let _ = writeln!(text, "\nby themselves");
    }
    for Measurement {
        function, median_ns, ..
    } in alone.into_iter().flatten()
    {
        let _ = writeln!(text, "  {function:width$}  {:>10}", time(*median_ns));
    }
    text
}

fn time(ns: f64) -> String {
    match ns {
        ns if ns < 1e3 => format!("{ns:.2} ns"),
        ns if ns < 1e6 => format!("{:.2} us", ns / 1e3),
        ns if ns < 1e9 => format!("{:.2} ms", ns / 1e6),
        ns => format!("{:.2} s", ns / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(json: &str, median_ns: f64) -> Measurement {
        serde_json::from_str::<Benchmark>(json)
            .unwrap()
            .measured(median_ns)
    }

    #[test]
    fn a_group_is_compared_with_its_quickest() {
        let mut measurements = [
            measured(
                r#"{"group_id": "read", "function_id": "mutex", "value_str": "48"}"#,
                15.0,
            ),
            measured(r#"{"group_id": "scan", "function_id": null}"#, 2.5e6),
            measured(
                r#"{"group_id": "read", "function_id": "cell", "value_str": "48"}"#,
                5.0,
            ),
        ];
        let expected = "
read
  cell/48      5.00 ns      1.00 x
  mutex/48    15.00 ns      3.00 x

by themselves
  scan         2.50 ms
";
        assert_eq!(tables(&mut measurements), expected);
    }
}
