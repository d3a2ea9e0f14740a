//! The particles: prediction by the motion, weights by a scan, resampling, and the estimate of the heaviest cluster.

use jde_grid::Geometry;
use jde_types::{Pose2D, normalize_angle};

use crate::beams::Beams;
use crate::bins::{Bins, bound};
use crate::field::LikelihoodField;
use crate::motion::OdometryMotion;
use crate::sensor::Likelihoods;

/// What the heaviest cluster of particles says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The mean pose, in the frame of the map.
    pub pose: Pose2D,
    /// The covariance of x, y and the heading, row by row: m², m rad, rad².
    pub covariance: [[f64; 3]; 3],
    /// The share of the weights that is in this cluster.
    pub share: f64,
    /// How many clusters there are.
    pub clusters: usize,
}

impl Estimate {
    /// The standard deviation of the position, m.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        libm::sqrt(self.covariance[0][0] + self.covariance[1][1])
    }

    /// The standard deviation of the heading, rad.
    #[must_use]
    pub fn heading_deviation(&self) -> f64 {
        libm::sqrt(self.covariance[2][2])
    }
}

/// The weighted sums of a cluster.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    weight: f64,
    x: f64,
    y: f64,
    cos: f64,
    sin: f64,
}

/// Weighted poses, in cells and radians. Nothing is allocated after the start.
#[derive(Clone, Debug)]
pub(crate) struct Particles {
    pub(crate) x: Vec<f32>,
    pub(crate) y: Vec<f32>,
    pub(crate) heading: Vec<f32>,
    /// They add up to 1.
    pub(crate) weight: Vec<f32>,
    most: usize,
    bins: Bins,
    /// For each particle: the logarithm of its likelihood, and the number of its cluster.
    scores: Vec<f32>,
    clusters: Vec<u32>,
    sums: Vec<Sums>,
    cumulative: Vec<f64>,
    next: [Vec<f32>; 3],
}

impl Particles {
    /// Returns room for `most` particles on a map with cells of `cell` m.
    pub(crate) fn new(most: usize, cell: f64) -> Self {
        let most = most.max(2);
        let room = || Vec::with_capacity(most);
        Self {
            x: room(),
            y: room(),
            heading: room(),
            weight: room(),
            most,
            bins: Bins::new(most, cell),
            scores: room(),
            clusters: Vec::with_capacity(most),
            sums: Vec::with_capacity(most),
            cumulative: Vec::with_capacity(most),
            next: [room(), room(), room()],
        }
    }

    pub(crate) const fn len(&self) -> usize {
        self.x.len()
    }

    /// How many there may be.
    pub(crate) const fn most(&self) -> usize {
        self.most
    }

    pub(crate) fn clear(&mut self) {
        for values in [&mut self.x, &mut self.y, &mut self.heading, &mut self.weight] {
            values.clear();
        }
    }

    /// Keeps only every second one, if they are more than half of what there may be.
    pub(crate) fn make_room(&mut self) {
        if self.len() > self.most / 2 {
            for values in [&mut self.x, &mut self.y, &mut self.heading, &mut self.weight] {
                let mut keep = false;
                values.retain(|_| {
                    keep = !keep;
                    keep
                });
            }
        }
    }

    /// Adds one, if there is room. All weights are equal after [`Self::level`].
    pub(crate) fn push(&mut self, pose: [f32; 3]) {
        if self.len() < self.most {
            let [x, y, heading] = pose;
            self.x.push(x);
            self.y.push(y);
            self.heading.push(heading);
            self.weight.push(0.0);
        }
    }

    /// Gives all the same weight.
    pub(crate) fn level(&mut self) {
        let share = 1.0 / self.len().max(1) as f32;
        self.weight.fill(share);
    }

    pub(crate) fn pose(&self, index: usize) -> [f32; 3] {
        [self.x[index], self.y[index], self.heading[index]]
    }

    /// Moves those from `first` on, each by a sample of the motion.
    pub(crate) fn predict(&mut self, first: usize, motion: &OdometryMotion, random: &mut fastrand::Rng) {
        for index in first..self.len() {
            let [x, y, heading] = motion.sample(self.pose(index), random);
            self.x[index] = x;
            self.y[index] = y;
            self.heading[index] = normalize(heading);
        }
    }

    /// Multiplies the weights by the likelihoods of a scan.
    pub(crate) fn weigh(&mut self, field: &LikelihoodField, likelihoods: &Likelihoods, beams: &Beams) {
        let mut scores = core::mem::take(&mut self.scores);
        scores.clear();
        scores.extend((0..self.len()).map(|index| likelihoods.of_scan(field, beams, self.pose(index))));
        let best = scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        for (weight, score) in self.weight.iter_mut().zip(&scores) {
            *weight *= libm::expf(score - best);
        }
        self.scores = scores;
        let sum: f64 = self.weight.iter().copied().map(f64::from).sum();
        // The best may have had a weight of 0 before.
        if sum > 1e-30 {
            let scale = (1.0 / sum) as f32;
            self.weight.iter_mut().for_each(|weight| *weight *= scale);
        } else {
            self.level();
        }
    }

    /// How many particles of equal weight are worth as much.
    pub(crate) fn effective(&self) -> f64 {
        let squares = self
            .weight
            .iter()
            .map(|&weight| f64::from(weight) * f64::from(weight));
        1.0 / squares.sum::<f64>()
    }

    /// Draws as many particles as KLD-sampling needs, at least `least`, by their weights: low-variance resampling
    /// ("Probabilistic Robotics", table 4.4). All weights are equal then.
    pub(crate) fn resample(
        &mut self,
        least: usize,
        (error, quantile): (f64, f64),
        random: &mut fastrand::Rng,
    ) {
        self.cumulative.clear();
        let mut sum = 0.0;
        self.cumulative.extend(self.weight.iter().map(|&weight| {
            sum += f64::from(weight);
            sum
        }));
        let count = self.needed(least, (error, quantile), sum, random);
        let step = sum / count as f64;
        let (mut at, mut index) = (random.f64() * step, 0);
        let [next_x, next_y, next_heading] = &mut self.next;
        for values in [&mut *next_x, &mut *next_y, &mut *next_heading] {
            values.clear();
        }
        for _ in 0..count {
            while index + 1 < self.cumulative.len() && self.cumulative[index] <= at {
                index += 1;
            }
            next_x.push(self.x[index]);
            next_y.push(self.y[index]);
            next_heading.push(self.heading[index]);
            at += step;
        }
        core::mem::swap(&mut self.x, next_x);
        core::mem::swap(&mut self.y, next_y);
        core::mem::swap(&mut self.heading, next_heading);
        self.weight.resize(count, 0.0);
        self.level();
    }

    /// How many particles are enough for the bins that samples of the weighted ones lie in.
    fn needed(
        &mut self,
        least: usize,
        (error, quantile): (f64, f64),
        sum: f64,
        random: &mut fastrand::Rng,
    ) -> usize {
        self.bins.clear();
        let (mut drawn, mut enough) = (0, least.clamp(1, self.most));
        while drawn < enough {
            let at = random.f64() * sum;
            let index = self.cumulative.partition_point(|&upto| upto <= at);
            let before = self.bins.len();
            self.bins.add(self.pose(index.min(self.len() - 1)));
            if self.bins.len() > before {
                enough = enough.max(bound(self.bins.len(), error, quantile)).min(self.most);
            }
            drawn += 1;
        }
        drawn
    }

    /// The estimate of the heaviest cluster; `None` without particles.
    pub(crate) fn estimate(&mut self, geometry: &Geometry) -> Option<Estimate> {
        self.bins.clear();
        self.clusters.clear();
        for index in 0..self.len() {
            let place = self.bins.add(self.pose(index));
            self.clusters.push(place as u32);
        }
        self.sums.clear();
        for index in 0..self.len() {
            let next = self.sums.len() as u32;
            let cluster = self.bins.cluster(self.clusters[index] as usize, next);
            self.clusters[index] = cluster;
            if cluster == next {
                self.sums.push(Sums::default());
            }
            let sums = &mut self.sums[cluster as usize];
            let weight = f64::from(self.weight[index]);
            let (sin, cos) = libm::sincosf(self.heading[index]);
            sums.weight += weight;
            sums.x += weight * f64::from(self.x[index]);
            sums.y += weight * f64::from(self.y[index]);
            sums.cos += weight * f64::from(cos);
            sums.sin += weight * f64::from(sin);
        }
        let heaviest = self
            .sums
            .iter()
            .zip(0..)
            .max_by(|(a, _), (b, _)| a.weight.total_cmp(&b.weight));
        let (&sums, cluster) = heaviest.filter(|(sums, _)| sums.weight > 0.0)?;
        let mean = [sums.x / sums.weight, sums.y / sums.weight];
        let heading = libm::atan2(sums.sin, sums.cos);
        Some(Estimate {
            pose: world(geometry, mean, heading),
            covariance: self.covariance(geometry, cluster, (mean, heading), sums.weight),
            share: sums.weight,
            clusters: self.sums.len(),
        })
    }

    fn covariance(
        &self,
        geometry: &Geometry,
        cluster: u32,
        (mean, heading): ([f64; 2], f64),
        total: f64,
    ) -> [[f64; 3]; 3] {
        let (sin, cos) = libm::sincos(geometry.origin().2);
        let mut covariance = [[0.0; 3]; 3];
        for index in (0..self.len()).filter(|&index| self.clusters[index] == cluster) {
            let weight = f64::from(self.weight[index]) / total;
            let along = (f64::from(self.x[index]) - mean[0]) * geometry.resolution();
            let across = (f64::from(self.y[index]) - mean[1]) * geometry.resolution();
            let apart = [
                cos * along - sin * across,
                sin * along + cos * across,
                normalize_angle(f64::from(self.heading[index]) - heading),
            ];
            for (row, &a) in covariance.iter_mut().zip(&apart) {
                for (value, &b) in row.iter_mut().zip(&apart) {
                    *value += weight * a * b;
                }
            }
        }
        covariance
    }
}

/// A pose of cells in the frame of the map.
pub(crate) fn world(geometry: &Geometry, [x, y]: [f64; 2], heading: f64) -> Pose2D {
    let (x, y) = geometry.to_world((x, y));
    Pose2D::new(x, y, normalize_angle(heading + geometry.origin().2))
}

/// A pose of the frame of the map in cells, the inverse of [`world`].
pub(crate) fn cells(geometry: &Geometry, pose: &Pose2D) -> [f32; 3] {
    let (x, y) = geometry.to_grid((pose.x, pose.y));
    [
        x as f32,
        y as f32,
        normalize_angle(pose.theta - geometry.origin().2) as f32,
    ]
}

/// The angle in [−π, π].
pub(crate) fn normalize(angle: f32) -> f32 {
    angle - core::f32::consts::TAU * libm::roundf(angle * (1.0 / core::f32::consts::TAU))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn particles(weights: &[f32]) -> Particles {
        let mut particles = Particles::new(weights.len().max(64), 0.1);
        for at in 0..weights.len() {
            particles.push([at as f32, 0.0, 0.0]);
        }
        let sum: f32 = weights.iter().sum();
        particles.weight = weights.iter().map(|weight| weight / sum).collect();
        particles
    }

    #[test]
    fn each_particle_is_drawn_as_often_as_its_weight_says() {
        let weights = [0.0, 1.0, 2.5, 0.25, 4.0, 0.05];
        let (total, draws) = (7.8, 2000);
        let mut counts = [0; 6];
        for seed in 0..draws {
            let mut drawn = particles(&weights);
            let mut random = fastrand::Rng::with_seed(seed);
            drawn.resample(20, (1000.0, 2.3), &mut random);
            assert_eq!(drawn.len(), 20);
            let mut copies = [0; 6];
            drawn.x.iter().for_each(|&x| copies[x as usize] += 1);
            for ((&weight, copies), count) in weights.iter().zip(copies).zip(&mut counts) {
                let expected = 20.0 * f64::from(weight) / total;
                assert!((f64::from(copies) - expected).abs() < 1.0, "low variance");
                *count += copies;
            }
        }
        for (&weight, count) in weights.iter().zip(counts) {
            let expected = 20.0 * f64::from(weight) / total;
            let mean = f64::from(count) / draws as f64;
            // Six standard errors of a number that differs by at most 1.
            assert!(
                (mean - expected).abs() < 6.0 * 0.5 / (draws as f64).sqrt(),
                "{mean} for {expected}"
            );
        }
    }

    #[test]
    fn spread_particles_are_many_and_those_at_one_place_few() {
        let mut spread = Particles::new(3000, 1.0);
        (0..3000).for_each(|at| spread.push([(at % 50) as f32, (at / 50) as f32, 0.0]));
        spread.level();
        let mut random = fastrand::Rng::with_seed(1);
        spread.resample(100, (0.05, 2.326), &mut random);
        assert_eq!(spread.len(), 3000, "no more than there may be");
        let mut near = Particles::new(3000, 1.0);
        (0..3000).for_each(|at| near.push([0.1 + at as f32 * 1e-5, 0.1, 0.1]));
        near.level();
        near.resample(100, (0.05, 2.326), &mut random);
        assert_eq!(near.len(), 100, "no fewer than there must be");
    }

    #[test]
    fn the_estimate_is_that_of_the_heaviest_cluster_in_the_frame_of_the_map() {
        let turned = Geometry::new(400, 400, 0.1, (1.0, 2.0, core::f64::consts::FRAC_PI_2)).expect("valid");
        let mut particles = Particles::new(64, 0.1);
        for (x, heading) in [(10.0, 3.1), (11.0, -3.1), (200.0, 0.0)] {
            particles.push([x, 20.0, heading]);
        }
        particles.weight = vec![0.35, 0.35, 0.3];
        let estimate = particles.estimate(&turned).expect("particles");
        assert_eq!(estimate.clusters, 2);
        assert!((estimate.share - 0.7).abs() < 1e-6);
        // 1.05 m along the grid, which is up, and 2 m across, which is to the left.
        let expected = Pose2D::new(-1.0, 3.05, -core::f64::consts::FRAC_PI_2);
        assert!(estimate.pose.distance_to(&expected) < 1e-6, "{:?}", estimate.pose);
        assert!(normalize_angle(estimate.pose.theta - expected.theta).abs() < 1e-3);
        assert!((estimate.deviation() - 0.05).abs() < 1e-6 && estimate.covariance[1][1] > 0.0024);
        assert!((estimate.heading_deviation() - 0.0416).abs() < 1e-3);
        assert_eq!(Particles::new(64, 0.1).estimate(&turned), None);
        assert_eq!(cells(&turned, &world(&turned, [3.0, 4.0], 0.5)), [3.0, 4.0, 0.5]);
    }

    proptest! {
        #[test]
        fn weights_add_up_to_one(weights in prop::collection::vec(0.0f32..1.0, 2..60), seed in any::<u64>()) {
            prop_assume!(weights.iter().sum::<f32>() > 0.0);
            let mut particles = particles(&weights);
            let sum = |particles: &Particles| particles.weight.iter().sum::<f32>();
            prop_assert!((sum(&particles) - 1.0).abs() < 1e-5);
            prop_assert!(particles.effective() <= particles.len() as f64 * 1.001);
            particles.resample(10, (0.05, 2.326), &mut fastrand::Rng::with_seed(seed));
            prop_assert!((sum(&particles) - 1.0).abs() < 1e-5);
            particles.make_room();
            particles.push([0.0; 3]);
            particles.level();
            prop_assert!((sum(&particles) - 1.0).abs() < 1e-5);
        }
    }
}
