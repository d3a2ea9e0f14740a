//! Recorded scans with marked legs.

use std::error::Error;

use jde_people::{DetectorSettings, Features, Hit, Segments, Stump};
use jde_types::LaserScan;

use crate::boosting::{Example, boost};
use crate::{ROUNDS, Score};

/// How far a segment may be from where a leg is marked, m.
const NEAR: f64 = 0.05;

/// Prints the scores on each recording: those without legs are shared out among those with legs.
pub(crate) fn measure(
    files: &[String],
    settings: &DetectorSettings,
    simulated: &[Stump],
) -> Result<(), Box<dyn Error>> {
    let mut with_legs = Vec::new();
    let mut without = Vec::new();
    for file in files {
        let examples = read(file, settings)?;
        let has_legs = examples.iter().any(|example| example.is_leg);
        if has_legs { &mut with_legs } else { &mut without }.push((file, examples));
    }
    let parts = with_legs.len().max(1);
    let others: Vec<Example> = without
        .iter()
        .flat_map(|(_, examples)| examples)
        .copied()
        .collect();
    let part = |number: usize| {
        let size = others.len().div_ceil(parts);
        (number * size).min(others.len())..((number + 1) * size).min(others.len())
    };
    let [mut by_simulation, mut by_others] = [Score::default(); 2];
    for (number, (file, examples)) in with_legs.iter().enumerate() {
        let own = part(number);
        let test: Vec<Example> = examples.iter().chain(&others[own.clone()]).copied().collect();
        let rest = with_legs.iter().enumerate().filter(|(other, _)| *other != number);
        let rest = rest.flat_map(|(_, (_, examples))| examples);
        let rest = rest.chain(&others[..own.start]).chain(&others[own.end..]);
        let trained = boost(&rest.copied().collect::<Vec<_>>(), ROUNDS);
        let scores = [Score::of(simulated, &test), Score::of(&trained, &test)];
        println!("{file}");
        println!("  by simulated scans:   {}", scores[0]);
        println!("  by other recordings:  {}", scores[1]);
        by_simulation.add(&scores[0]);
        by_others.add(&scores[1]);
    }
    println!("all, by simulated scans:  {by_simulation}");
    println!("all, by other recordings: {by_others}");
    Ok(())
}

fn read(file: &str, settings: &DetectorSettings) -> Result<Vec<Example>, Box<dyn Error>> {
    let mut examples = Vec::new();
    let mut segments = Segments::default();
    let text = std::fs::read_to_string(file)?;
    let has_legs = text.lines().any(|line| !line.ends_with(" 0"));
    for (number, line) in text.lines().enumerate() {
        let (scan, legs) = parse(line).ok_or_else(|| format!("{file}:{}: is not a scan", number + 1))?;
        if segments.update(&scan, settings.jump).is_err() {
            continue;
        }
        for segment in segments.segments() {
            let hits = &segments.hits()[segment.hits.clone()];
            if !settings.admits(hits) || has_legs != is_marked(hits, &legs) {
                continue;
            }
            examples.push(Example {
                features: Features::new(segments.hits(), segment),
                is_leg: has_legs,
            });
        }
    }
    Ok(examples)
}

fn is_marked(hits: &[Hit], legs: &[(f64, f64)]) -> bool {
    let count = hits.len() as f64;
    let (x, y) = hits
        .iter()
        .fold((0.0, 0.0), |(x, y), hit| (x + hit.x / count, y + hit.y / count));
    legs.iter().any(|leg| (leg.0 - x).hypot(leg.1 - y) < NEAR)
}

fn parse(line: &str) -> Option<(LaserScan, Vec<(f64, f64)>)> {
    let mut numbers = line.split_whitespace();
    let mut next = || numbers.next()?.parse::<f64>().ok();
    let mut scan = LaserScan {
        angle_min: next()? as f32,
        angle_increment: next()? as f32,
        range_min: 0.05,
        range_max: 30.0,
        ..LaserScan::default()
    };
    for _ in 0..next()? as usize {
        let range = next()? as f32;
        let is_return = range >= scan.range_min;
        scan.ranges
            .push(if is_return { range } else { f32::INFINITY })
            .ok()?;
    }
    scan.state_last_angle();
    let legs = next()? as usize;
    let legs = (0..legs)
        .map(|_| Some((next()?, next()?)))
        .collect::<Option<_>>()?;
    Some((scan, legs))
}
