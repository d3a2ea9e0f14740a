//! Gentle AdaBoost with decision stumps (Friedman, Hastie, Tibshirani, 2000).

use jde_people::{FEATURES, Features, Stump};

/// A segment, and whether it is a leg.
#[derive(Clone, Copy)]
pub(crate) struct Example {
    pub(crate) features: Features,
    pub(crate) is_leg: bool,
}

/// The most thresholds that are tried for one feature.
const THRESHOLDS: usize = 200;

/// Returns `rounds` stumps. Legs count as much as all else together.
pub(crate) fn boost(examples: &[Example], rounds: usize) -> Vec<Stump> {
    let legs = examples.iter().filter(|example| example.is_leg).count() as f64;
    let others = examples.len() as f64 - legs;
    let mut weights: Vec<f64> = examples
        .iter()
        .map(|example| 0.5 / if example.is_leg { legs } else { others })
        .collect();
    let orders: Vec<Vec<usize>> = (0..FEATURES).map(|feature| order(examples, feature)).collect();
    let mut stumps = Vec::new();
    for _ in 0..rounds {
        let best = (0..FEATURES)
            .filter_map(|feature| fit(examples, &weights, &orders[feature], feature))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, stump)) = best else { break };
        for (weight, example) in weights.iter_mut().zip(examples) {
            let above = example.features.0[stump.feature] >= stump.threshold;
            let value = if above { stump.above } else { stump.below };
            *weight *= (-sign(example) * value).exp();
        }
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        stumps.push(stump);
    }
    stumps
}

fn sign(example: &Example) -> f64 {
    if example.is_leg { 1.0 } else { -1.0 }
}

/// Returns the examples by one feature.
fn order(examples: &[Example], feature: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..examples.len()).collect();
    let value = |index: &usize| examples[*index].features.0[feature];
    order.sort_by(|a, b| value(a).total_cmp(&value(b)));
    order
}

/// Returns the stump of one feature with the least squares of the errors, and these.
fn fit(examples: &[Example], weights: &[f64], order: &[usize], feature: usize) -> Option<(f64, Stump)> {
    let value = |index: usize| examples[index].features.0[feature];
    let signed = |index: usize| weights[index] * sign(&examples[index]);
    let total: f64 = order.iter().map(|&index| weights[index]).sum();
    let sum: f64 = order.iter().map(|&index| signed(index)).sum();
    let (mut below, mut sum_below) = (0.0, 0.0);
    let mut best: Option<(f64, Stump)> = None;
    let stride = order.len().div_ceil(THRESHOLDS);
    for (position, pair) in order.windows(2).enumerate() {
        below += weights[pair[0]];
        sum_below += signed(pair[0]);
        if value(pair[0]) == value(pair[1]) || position % stride != 0 {
            continue;
        }
        let above = total - below;
        let explained = sum_below * sum_below / below + (sum - sum_below) * (sum - sum_below) / above;
        let error = total - explained;
        if best.is_none_or(|(least, _)| error < least) {
            let stump = Stump {
                feature,
                threshold: f64::midpoint(value(pair[0]), value(pair[1])),
                below: sum_below / below,
                above: (sum - sum_below) / above,
            };
            best = Some((error, stump));
        }
    }
    best
}
