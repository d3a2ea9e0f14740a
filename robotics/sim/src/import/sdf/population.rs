//! Populations: many copies of one model, as Gazebo places them (`physics/Population.cc` of Gazebo 11).

use std::f64::consts::TAU;

use super::pose3::Pose3;
use super::values;
use super::xml::Node;

/// The fractional parts of the multiples of these numbers fill a cube evenly (Roberts, *The Unreasonable Effectiveness of
/// Quasirandom Sequences*, 2018).
const EVEN: [f64; 3] = [
    0.819_172_513_396_164_4,
    0.671_043_606_703_789_2,
    0.549_700_477_901_970_2,
];

/// The places of a population, m. They have the axes of the world.
pub(super) struct Places {
    pub(super) count: u64,
    /// Gazebo draws them at each start.
    pub(super) are_drawn: bool,
    origin: Pose3,
    kind: Kind,
}

enum Kind {
    Grid {
        columns: u64,
        step: [f64; 3],
    },
    /// Along an axis of a box, in the middle of its other sides.
    Line {
        axis: usize,
        size: [f64; 3],
    },
    Box([f64; 3]),
    Cylinder {
        radius: f64,
        length: f64,
    },
}

impl Places {
    /// Reads a population, or says what is wrong with it.
    pub(super) fn read(population: &Node) -> Result<Self, String> {
        let distribution = population
            .child("distribution")
            .ok_or("it has no `<distribution>`")?;
        let kind = distribution.child("type").map(|node| node.text().to_owned());
        let kind = kind.unwrap_or_else(|| "random".to_owned());
        let origin =
            values::pose(population).map_err(|(_, message)| format!("its pose is wrong: {message}"))?;
        let mut origin = origin.pose;
        let count = |node: &Node, key: &str| {
            let number = node
                .child(key)
                .map_or(Some(1.0), |node| values::numbers(&node).map(|[number]| number));
            let number = number.filter(|number| (1.0..1e9).contains(number));
            number
                .map(|number| number as u64)
                .ok_or_else(|| format!("its `{key}` is not a number from 1"))
        };
        let sizes = |key: &str, inner: &str| {
            let node = population.child(key).and_then(|node| node.child(inner));
            node.as_ref().and_then(values::numbers::<3>)
        };
        let length = |key: &str| {
            let node = population.child("cylinder").and_then(|node| node.child(key));
            let number = node.as_ref().and_then(values::numbers).map(|[number]| number);
            number
                .filter(|number| *number > 0.0)
                .ok_or_else(|| format!("its cylinder has no `{key}` above 0"))
        };
        if kind == "grid" {
            let (rows, columns) = (count(&distribution, "rows")?, count(&distribution, "cols")?);
            let step = match distribution.child("step") {
                Some(node) => values::numbers(&node).ok_or("its `step` is wrong: expected x y z")?,
                None => [0.5, 0.5, 0.0],
            };
            // The pose is the middle of the grid.
            origin.at[0] -= step[0] * (columns - 1) as f64 / 2.0;
            origin.at[1] -= step[1] * (rows - 1) as f64 / 2.0;
            return Ok(Self {
                count: rows * columns,
                are_drawn: false,
                origin,
                kind: Kind::Grid { columns, step },
            });
        }
        let count = count(population, "model_count")?;
        let line = ["linear-x", "linear-y", "linear-z"]
            .iter()
            .position(|line| *line == kind);
        let is_drawn = matches!(kind.as_str(), "random" | "uniform");
        if line.is_none() && !is_drawn {
            return Err(format!("its distribution `{kind}` is not known"));
        }
        let kind = if population.child("box").is_some() {
            let size = sizes("box", "size").filter(|size| size.iter().all(|side| *side > 0.0));
            let size = size.ok_or("its box has no `size` above 0")?;
            // The pose is the middle of the box.
            origin.at = [0, 1, 2].map(|axis| origin.at[axis] - size[axis] / 2.0);
            line.map_or(Kind::Box(size), |axis| Kind::Line { axis, size })
        } else if population.child("cylinder").is_some() && is_drawn {
            Kind::Cylinder {
                radius: length("radius")?,
                length: length("length")?,
            }
        } else {
            return Err("it has no `<box>` that it fills".to_owned());
        };
        Ok(Self {
            count,
            are_drawn: is_drawn,
            origin,
            kind,
        })
    }

    /// Returns a place by its number.
    pub(super) fn place(&self, index: u64) -> [f64; 3] {
        let parts = EVEN.map(|part| (0.5 + part * (index + 1) as f64).fract());
        let inner = match self.kind {
            Kind::Grid { columns, step } => [
                step[0] * (index % columns) as f64,
                step[1] * (index / columns) as f64,
                0.0,
            ],
            Kind::Line { axis, size } => {
                let mut place = size.map(|side| side / 2.0);
                place[axis] = size[axis] * index as f64 / self.count as f64;
                place
            }
            Kind::Box(size) => [0, 1, 2].map(|axis| size[axis] * parts[axis]),
            Kind::Cylinder { radius, length } => {
                let (sin, cos) = libm::sincos(TAU * parts[0]);
                let radius = radius * parts[1].sqrt();
                [radius * cos, radius * sin, length * parts[2]]
            }
        };
        self.origin.point(inner)
    }
}
