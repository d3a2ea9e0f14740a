//! The models of the laser: how likely a scan is at a pose, and how far it agrees with the map there.

use crate::beams::{Beam, Beams};
use crate::field::LikelihoodField;

/// How the likelihood of a beam is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// By the distance from its end to the nearest obstacle ("Probabilistic Robotics", table 6.3). Fast and smooth; it
    /// does not notice that a beam passes through a wall.
    #[default]
    LikelihoodField,
    /// By the difference of its length from that of a ray through the map (table 6.1).
    Beam,
}

/// A model and its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// How the likelihood of a beam is computed.
    pub model: Model,
    /// The standard deviation of the ends of beams from the obstacles of the map, m: that of the laser and of the map.
    pub deviation: f64,
    /// The likelihood of a beam that hits something else, where that of one that fits exactly is about 1.
    pub outliers: f64,
    /// For how many independent measurements a scan counts. Beams that are next to each other err alike.
    pub independent: f64,
}

impl Default for Sensor {
    fn default() -> Self {
        Self {
            model: Model::LikelihoodField,
            deviation: 0.1,
            outliers: 0.1,
            independent: 20.0,
        }
    }
}

impl Sensor {
    /// The logarithm of the likelihood of a beam that ends `apart` m from where it should.
    pub(crate) fn logarithm(&self, apart: f64) -> f32 {
        let apart = apart / self.deviation;
        libm::log((1.0 - self.outliers) * libm::exp(-0.5 * apart * apart) + self.outliers) as f32
    }
}

/// A beam that is longer than a ray through the map passes through what the map has. So it is less likely than one that
/// is shorter, which hits what the map does not have.
const THROUGH: f64 = 0.1;
/// How far behind the end of a beam a ray is followed, in cells.
const FAR_BEHIND: f32 = 32.0;

/// The logarithms of likelihoods, prepared for a field.
#[derive(Clone, Debug)]
pub(crate) struct Likelihoods {
    sensor: Sensor,
    cell: f64,
    /// By the distance in parts of a cell.
    by_parts: [f32; 256],
}

impl Likelihoods {
    pub(crate) fn new(sensor: Sensor, cell: f64) -> Self {
        let mut by_parts = [0.0; 256];
        for (logarithm, distance) in by_parts.iter_mut().zip(LikelihoodField::distances()) {
            *logarithm = sensor.logarithm(f64::from(distance) * cell);
        }
        Self {
            sensor,
            cell,
            by_parts,
        }
    }

    /// The side of a cell, m.
    pub(crate) const fn cell(&self) -> f32 {
        self.cell as f32
    }

    /// Whether they are of this sensor.
    pub(crate) fn is_of(&self, sensor: &Sensor) -> bool {
        self.sensor == *sensor
    }

    /// The logarithm of the likelihood of a scan at a pose in cells. Outside the free cells each beam is an outlier.
    pub(crate) fn of_scan(&self, field: &LikelihoodField, beams: &Beams, [x, y, heading]: [f32; 3]) -> f32 {
        let beams_of = beams.as_slice();
        let share = (self.sensor.independent as f32 / beams_of.len().max(1) as f32).min(1.0);
        if !field.is_free(x, y) {
            return share * beams_of.len() as f32 * self.by_parts[255];
        }
        let sum: f32 = match self.sensor.model {
            Model::LikelihoodField => self.of_ends(field, beams, [x, y, heading]),
            Model::Beam => {
                let scale = 1.0 / self.cell as f32;
                let (sin, cos) = libm::sincosf(heading);
                let (ahead, left) = beams.mount();
                let from = (
                    x + scale * (cos * ahead - sin * left),
                    y + scale * (sin * ahead + cos * left),
                );
                let one = |beam: &Beam| {
                    let (ahead, left) = beam.direction;
                    let direction = (cos * ahead - sin * left, sin * ahead + cos * left);
                    let length = beam.range * scale;
                    let ray = field.cast(from, direction, length + FAR_BEHIND);
                    let apart = f64::from(length - ray) * self.cell;
                    let outliers = if apart > 0.0 { THROUGH } else { 1.0 };
                    let sensor = Sensor {
                        outliers: self.sensor.outliers * outliers,
                        ..self.sensor
                    };
                    sensor.logarithm(apart)
                };
                beams_of.iter().map(one).sum()
            }
        };
        share * sum
    }

    /// The sum of the logarithms of the likelihoods of the beams by their ends.
    pub(crate) fn of_ends(&self, field: &LikelihoodField, beams: &Beams, [x, y, heading]: [f32; 3]) -> f32 {
        let scale = 1.0 / self.cell as f32;
        let (sin, cos) = libm::sincosf(heading);
        let (along, across) = (cos * scale, sin * scale);
        let ends = beams.as_slice().iter().map(|beam| {
            let (ahead, left) = beam.end;
            let (x, y) = (
                x + along * ahead - across * left,
                y + across * ahead + along * left,
            );
            self.by_parts[field.parts(x, y) as usize]
        });
        ends.sum()
    }
}

#[cfg(test)]
mod tests {
    use jde_types::{LaserScan, Pose2D};

    use super::*;
    use crate::field::tests::map;
    use crate::fit::Comparison;

    const CELL: f64 = 0.1;

    /// A room of 2 × 1 m with a wall that leaves a gap, in cells of 0.1 m.
    fn field() -> LikelihoodField {
        LikelihoodField::new(&map(&[
            "######################",
            "#.........#..........#",
            "#.........#..........#",
            "#....................#",
            "#.........#..........#",
            "#.........#..........#",
            "######################",
        ]))
    }

    /// What a laser sees at a pose in cells, by the field's own rays, with 36 beams all around.
    fn beams(field: &LikelihoodField, [x, y, heading]: [f32; 3]) -> Beams {
        let mut scan = LaserScan {
            angle_increment: core::f32::consts::TAU / 36.0,
            range_max: 8.0,
            ..LaserScan::default()
        };
        for beam in 0..36 {
            let (sin, cos) = libm::sincosf(heading + scan.angle(beam) as f32);
            let way = field.cast((x, y), (cos, sin), 60.0);
            scan.ranges.push(way * CELL as f32).expect("few beams");
        }
        scan.state_last_angle();
        let mut beams = Beams::new(36);
        beams.update(&scan, |_| Pose2D::ORIGIN).expect("all hit");
        beams
    }

    const TRUE: [f32; 3] = [4.5, 2.5, 0.3];

    fn agreement(
        field: &LikelihoodField,
        beams: &Beams,
        pose: [f32; 3],
        (tolerance, cell): (f32, f64),
    ) -> f32 {
        let likelihoods = Likelihoods::new(Sensor::default(), cell);
        let scan = Comparison {
            field,
            likelihoods: &likelihoods,
            beams,
            tolerance,
        };
        scan.fit(pose).agreeing
    }

    #[test]
    fn by_either_model_the_true_pose_is_the_likeliest() {
        let field = field();
        let beams = beams(&field, TRUE);
        for model in [Model::LikelihoodField, Model::Beam] {
            let sensor = Sensor {
                model,
                ..Sensor::default()
            };
            let likelihoods = Likelihoods::new(sensor, CELL);
            let at = |pose| likelihoods.of_scan(&field, &beams, pose);
            let [x, y, heading] = TRUE;
            for wrong in [
                [x + 2.0, y, heading],
                [x, y - 1.5, heading],
                [x, y, heading + 0.4],
                [x + 10.0, y, heading],
                [x, 5.9, heading],
                [-3.0, y, heading],
            ] {
                assert!(at(TRUE) > at(wrong) + 0.5, "{model:?}: {wrong:?}");
            }
        }
    }

    #[test]
    fn only_the_beam_model_and_the_agreement_notice_a_wall_on_the_way() {
        // The other half of the room is as wide: what is seen there fits here too, but for the wall between.
        let rows = [
            "######################",
            "#.........#..........#",
            "######################",
        ];
        let field = LikelihoodField::new(&map(&rows));
        let mut scan = LaserScan {
            // Too little to matter.
            angle_increment: 1e-9,
            range_max: 8.0,
            ..LaserScan::default()
        };
        // All beams go ahead, through the wall to the far end.
        (0..12).for_each(|_| scan.ranges.push(1.62).expect("few beams"));
        scan.state_last_angle();
        let mut beams = Beams::new(12);
        beams.update(&scan, |_| Pose2D::ORIGIN).expect("all hit");
        let pose = [5.0, 1.5, 0.0];
        let of = |model| {
            let sensor = Sensor {
                model,
                ..Sensor::default()
            };
            Likelihoods::new(sensor, CELL).of_scan(&field, &beams, pose)
        };
        assert!(of(Model::LikelihoodField) > -1.0 && of(Model::Beam) < -20.0);
        assert_eq!(agreement(&field, &beams, pose, (2.5, CELL)), 0.0);
        assert_eq!(
            agreement(&field, &beams, [12.0, 1.5, 0.0], (2.5, CELL)),
            0.0,
            "behind the end"
        );
    }

    #[test]
    fn beams_agree_within_the_tolerance_and_none_outside_free_cells() {
        let field = field();
        let beams = beams(&field, TRUE);
        let at = |pose| agreement(&field, &beams, pose, (2.5, CELL));
        let [x, y, heading] = TRUE;
        assert_eq!(at(TRUE), 1.0);
        assert!(at([x + 0.5, y, heading]) > 0.9);
        assert!(at([x + 10.0, y + 1.0, heading]) < 0.8);
        assert_eq!(at([0.5, y, heading]), 0.0, "in a wall");
        assert_eq!(at([f32::NAN, y, heading]), 0.0);
    }

    /// The field ends at 32 cells; with cells of 5 mm that is 0.16 m.
    #[test]
    fn what_is_far_from_all_obstacles_of_a_fine_map_does_not_agree() {
        let mut rows = vec![".".repeat(60); 60];
        rows[0] = "#".repeat(60);
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let field = LikelihoodField::new(&map(&rows));
        let mut scan = LaserScan {
            // Too little to matter.
            angle_increment: 1e-9,
            range_max: 8.0,
            ..LaserScan::default()
        };
        (0..12).for_each(|_| scan.ranges.push(0.1).expect("few beams"));
        scan.state_last_angle();
        let mut beams = Beams::new(12);
        beams.update(&scan, |_| Pose2D::ORIGIN).expect("all hit");
        let pose = [5.0, 5.0, 0.0];
        assert_eq!(agreement(&field, &beams, pose, (50.0, 0.005)), 0.0);
        let sensor = Sensor::default();
        let outlier = libm::log(sensor.outliers) as f32;
        let likelihood = Likelihoods::new(sensor, 0.005).of_scan(&field, &beams, pose);
        assert!((likelihood - 12.0 * outlier).abs() < 1e-3, "{likelihood}");
    }

    #[test]
    fn a_scan_counts_for_so_many_independent_measurements() {
        let field = field();
        let beams = beams(&field, TRUE);
        let of = |independent| {
            let sensor = Sensor {
                independent,
                ..Sensor::default()
            };
            Likelihoods::new(sensor, CELL).of_scan(&field, &beams, [6.5, 2.5, 0.3])
        };
        assert!((of(36.0) - 4.0 * of(9.0)).abs() < 1e-3 && of(1000.0) == of(36.0));
    }
}
