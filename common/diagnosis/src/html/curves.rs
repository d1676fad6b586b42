//! The fitted curve of each effect with its band, and the curve of what is missing.

use super::chart::{Frame, legend, range, svg, with_unit};
use super::document::filled;
use crate::answer::schema::Report;
use crate::answer::supplement::{Axis, Curve, CurvePoint, Detail};
use crate::words::format::{capital, gap, number_to, on_axis, or_list, plain, term};
use crate::words::sentences::{law, place};
use maud::{Markup, html};
use railgrip_words::{reword, say, t};

/// Curves of the effects found.
pub fn effects(report: &Report, detail: &Detail) -> Markup {
    html! {
        @if !detail.effect_curves.is_empty() {
            section aria-labelledby="effect" {
                h2 id="effect" { @if report.effects.len() > 1 { (t("The effects, as fitted")) } @else { (t("The effect, as fitted")) } }
                p.say { (t("Line: the extended model. Band: its 95 % interval by noise. Dashed: the calibrated model, which lacks the effect.")) }
                (legend(
                    detail.effect_curves.iter().any(|curve| !curve.data.is_empty()).then_some("bins"),
                    &[("calibrated-line", t("calibrated")), ("extended-line", t("extended"))],
                ))
                div class=(if detail.effect_curves.len() > 1 { "pair" } else { "" }) {
                    @for (index, curve) in detail.effect_curves.iter().enumerate() {
                        (figure(curve, &format!("effect-{index}"), detail.effect_curves.len() > 1))
                    }
                }
            }
        }
    }
}

/// The curve of what is missing.
pub fn missing(report: &Report, detail: &Detail) -> Markup {
    html! {
        @if let Some(rest) = &report.unexplained {
            section aria-labelledby="missing" {
                h2 id="missing" { (t("What is missing")) }
                p.say {
                    (filled("Something in {place} ({code}).", &[("place", html! { b { (place(report)) } }), ("code", html! { code { (rest.term) } })]))
                    " "
                    @if rest.terms.len() > 1 {
                        @let names = or_list(&rest.terms.iter().map(|name| term(name)).collect::<Vec<_>>());
                        (say("These recordings cannot tell apart {names}, the likeliest first; the curve is drawn for the first.", &[("names", &names)]))
                        " "
                    }
                    (filled("The gap left on the fitted data is {gap}.", &[("gap", html! { b { (gap(rest.gap)) } })]))
                    @if let Some((curve, region)) = detail.missing_curve.as_ref().and_then(|curve| Some((curve, curve.region?))) {
                        @let [low, high] = region.map(|end| number_to(end, 2));
                        @let unit = if curve.x.unit.is_empty() { String::new() } else { format!(" {}", curve.x.unit) };
                        " " (say("It matters most from {low} to {high}{unit} (shaded).", &[("low", &low), ("high", &high), ("unit", &unit)]))
                    }
                }
                @if let Some(curve) = &detail.missing_curve {
                    (legend(None, &[("calibrated-line", t("nothing missing")), ("extended-line", t("what would close the gap"))]))
                    (figure(curve, "missing-curve", false))
                }
            }
        }
    }
}

fn figure(curve: &Curve, id: &str, narrow: bool) -> Markup {
    let inner = |point: &CurvePoint| (point.high - point.low).abs();
    let mut widths: Vec<f64> = curve.points.iter().map(inner).filter(|w| w.is_finite()).collect();
    widths.sort_by(f64::total_cmp);
    // A band that explodes at one end must not flatten the curve.
    let usual = widths.get(widths.len() * 3 / 4).copied().unwrap_or(0.0);
    let band = curve
        .points
        .iter()
        .filter(|point| inner(point) <= 2.0 * usual)
        .flat_map(|point| [point.low, point.high]);
    let line = curve.points.iter().map(|point| point.y);
    let rest = curve.data.iter().chain(&curve.reference).map(|point| point[1]);
    let xs = curve.points.iter().map(|point| point.x);
    let (Some(x), Some(y)) = (range(xs), range(band.chain(line).chain(rest))) else { return html! {} };
    let (width, height) = if narrow { (430.0, 290.0) } else { (860.0, 340.0) };
    let frame = Frame { left: 64.0, top: 30.0, width: width - 76.0, height: height - 74.0, x, y };
    let band: Vec<(f64, f64, f64)> = curve.points.iter().map(|p| (p.x, p.low, p.high)).collect();
    let marks = html! {
        @if let Some([low, high]) = curve.region { (frame.region("region", low, high)) }
        (frame.axes(Some(&curve.x), &with_unit(&curve.y), 5))
        (frame.clipped(id, html! {
            (frame.band(&band))
            (frame.line("calibrated-line", curve.reference.iter().copied()))
            (frame.line("extended-line", curve.points.iter().map(|p| [p.x, p.y])))
            (frame.dots("bin", 3.2, &curve.data))
        }))
    };
    let heading = reword(&curve.title.replace('_', " "));
    let over =
        say("{what} over {when}", &[("what", &plain(&curve.y.label)), ("when", &plain(&curve.x.label))]);
    let title = format!("{heading}: {over}");
    html! {
        figure {
            div.scroll { (svg("plot", width, height, &title, &ends(curve), &marks)) }
            figcaption {
                b { (capital(&heading)) }
                @if !curve.equation.is_empty() { ": " (law(&curve.equation)) }
                ". " (ends(curve)) "."
            }
        }
    }
}

/// The curve in words: its values at both ends.
fn ends(curve: &Curve) -> String {
    let span = |of: fn(&CurvePoint) -> f64| {
        let (low, high) = curve
            .points
            .iter()
            .map(of)
            .filter(|x| x.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        (high - low).max(high.abs().max(low.abs()) * 1e-3)
    };
    let (x_span, y_span) = (span(|p| p.x), span(|p| p.y));
    let unit = |axis: &Axis| if axis.unit.is_empty() { String::new() } else { format!(" {}", axis.unit) };
    let point = |p: &CurvePoint| {
        let [y, x] = [on_axis(p.y, y_span) + &unit(&curve.y), on_axis(p.x, x_span) + &unit(&curve.x)];
        say("{y} at {x}", &[("y", &y), ("x", &x)])
    };
    match (curve.points.first(), curve.points.last()) {
        (Some(first), Some(last)) => {
            say("From {first} to {last}", &[("first", &point(first)), ("last", &point(last))])
        }
        _ => t("No data").to_owned(),
    }
}
