//! The panel: the tags, the pose, and how sure it is.

use jde_schema::prelude::*;

use super::Tags;

impl Panel for Tags {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        pen.text(&self.words);
        let places = self.places.get(cx);
        pen.canvas("map").show(|map| {
            for tag in places.tags.iter() {
                let front = tag.pose.transform(&Pose2D::new(0.3, 0.0, 0.0));
                map.arrow((tag.pose.x, tag.pose.y), (front.x, front.y))
                    .ink(Ink::Accent);
                map.label((tag.pose.x, tag.pose.y), tag.id.to_string());
            }
            if let Some(estimate) = &self.estimate {
                let [deviation, _] = estimate.deviations();
                map.circle((estimate.pose.x, estimate.pose.y), 2.0 * deviation)
                    .ink(Ink::Warn);
                map.robot(&estimate.pose);
            }
        });
    }
}
