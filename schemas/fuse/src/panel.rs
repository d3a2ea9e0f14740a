//! The panel: where the robot is by the filter and by its wheels alone, and how well that is known.

use jde_schema::prelude::*;

use super::Ekf;

impl Panel for Ekf {
    fn draw(&self, _: &Context, pen: &mut Pen) {
        pen.text(&self.words);
        let Some(timeline) = &self.timeline else { return };
        let filter = timeline.newest().1;
        let state = *filter.state();
        pen.row(|pen| {
            pen.value("bias", state.bias.to_degrees(), "degrees/s");
            pen.value("to", filter.bias_deviation().to_degrees(), "degrees/s");
        });
        pen.row(|pen| {
            pen.value("wheels: ways too long by", 100.0 * state.way_scale, "%");
            pen.value("turns by", 100.0 * state.turn_scale, "%");
        });
        pen.canvas("place").show(|area| {
            let covariance = filter.pose_covariance();
            let deviation = covariance[0][0].max(covariance[1][1]).max(0.0).sqrt();
            area.circle((state.x, state.y), 2.0 * deviation).ink(Ink::Warn);
            if let Some((_, wheels)) = self.rolled {
                let front = wheels.transform(&Pose2D::new(0.3, 0.0, 0.0));
                area.arrow((wheels.x, wheels.y), (front.x, front.y))
                    .ink(Ink::Plain);
            }
            area.robot(&Pose2D::new(state.x, state.y, state.yaw));
        });
        pen.text("The arrow is where the wheels alone say.");
    }
}
