//! The recorded topics with their types, rates and losses.

use jde_drawing::text::format_size;
use maud::{Markup, html};

use super::{Page, counted, trouble};

pub(super) fn topics(page: &Page<'_>) -> Option<Markup> {
    let survey = &page.analysis.survey;
    if survey.topics.is_empty() {
        return None;
    }
    Some(html! {
        details {
            summary {
                (counted(survey.messages, "message")) " on " (counted(survey.topics.len() as u64, "topic")) ", " (format_size(survey.bytes))
            }
            div.scroll {
                table {
                    thead { tr {
                        th { "topic" } th { "type" } th.n { "messages" } th.n { "rate" } th.n { "size" } th.n { "lost" }
                    } }
                    tbody {
                        @for topic in &survey.topics {
                            tr {
                                td.name { (topic.topic) }
                                td { (topic.type_name) }
                                td.n { (topic.messages) }
                                td.n { @if let Some(hz) = topic.rate_hz { (format!("{hz:.1} Hz")) } @else { "–" } }
                                td.n { (format_size(topic.bytes)) }
                                td.n { (trouble(survey.lost.get(&topic.topic).copied().unwrap_or(0))) }
                            }
                        }
                    }
                }
            }
            @if !survey.attachments.is_empty() { p.note { "With " (survey.attachments.join(", ")) "." } }
        }
    })
}
