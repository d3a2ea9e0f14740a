//! The panel: the scan, what is bright in it, and the reflector.

use jde_schema::prelude::*;

use super::Reflector;

impl Panel for Reflector {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        pen.text(&self.words);
        let Some(scan) = self.laser.get(cx) else {
            return;
        };
        let beams = || scan.intensities.iter().enumerate();
        pen.plot("intensities", "intensity of each beam").show(|plot| {
            plot.curve(
                "measured",
                beams().map(|(beam, value)| (beam as f64, f64::from(*value))),
            );
            let least = self.bright.get(cx);
            plot.curve("least", [(0.0, least), (scan.ranges.len() as f64, least)])
                .ink(Ink::Warn);
        });
        pen.canvas("scan").forward_up().show(|field| {
            field.points(scan.points()).width(2.0);
            field
                .points(self.seen.iter().map(|thing| thing.middle))
                .ink(Ink::Accent)
                .width(6.0);
            if let Some(pose) = self.found {
                let front = pose.transform(&Pose2D::new(0.5, 0.0, 0.0));
                field.arrow((pose.x, pose.y), (front.x, front.y)).ink(Ink::Good);
            }
            field.robot(&Pose2D::ORIGIN);
        });
    }
}
