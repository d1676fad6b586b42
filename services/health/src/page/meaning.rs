//! What every figure means: definition, unit, interval, limits and what it cannot see. The limits are those of the running
//! train, so that this page and the grades cannot contradict each other.

use crate::limits::Limits;
use crate::store::capability::{ACT_RATIO, WATCH_RATIO};
use maud::{Markup, html};

/// One figure, by the block of ISO 13374 that it belongs to.
struct Meaning {
    id: &'static str,
    name: &'static str,
    /// Block of ISO 13374.
    block: &'static str,
    is: &'static str,
    unit: &'static str,
    interval: &'static str,
    limits: String,
    blind: &'static str,
}

pub(super) fn body(limits: &Limits) -> Markup {
    let all = brakes(limits).into_iter().chain(rail(limits)).chain(data(limits)).chain(train(limits));
    let all: Vec<Meaning> = all.collect();
    html! {
        h1 .page { "What the figures mean" }
        section .card aria-labelledby="h-grades" {
            h2 #h-grades { "Grades, intervals and ages" }
            p { "Ok: as it should be. Watch: worth a look at the next occasion. Act: needs action. Unknown: not enough fresh data to judge. "
                "A limit counts as passed only when the whole 95 % interval lies beyond it, so an uncertain figure raises no alarm; "
                "the reason then says that the figure is too uncertain. Old data are marked as stale with their age, and are not judged." }
            p { "The words at the right are the processing blocks of ISO 13374: acquisition, manipulation, state detection, health assessment, prognosis, advisory." }
            nav .contents aria-label="Figures" { @for one in &all { a href={ "#" (one.id) } { (one.name) } " " } }
        }
        @for one in &all { (entry(one)) }
    }
}

fn entry(one: &Meaning) -> Markup {
    html! {
        section .card.meaning id=(one.id) aria-labelledby={ "m-" (one.id) } {
            div .heading { h2 id={ "m-" (one.id) } { (one.name) } span .legend { (one.block) } }
            p { (one.is) }
            dl .meanings {
                div { dt { "Unit" } dd { (one.unit) } }
                div { dt { "Interval" } dd { (one.interval) } }
                div { dt { "Limits" } dd { (one.limits) } }
                div { dt { "Cannot see" } dd { (one.blind) } }
            }
        }
    }
}

fn brakes(limits: &Limits) -> Vec<Meaning> {
    let set = &limits.settings;
    let friction = &set.brake_friction;
    let ratio = format!(
        "Of nominal: watch below {:.0} % or above {:.0} %, act below {:.0} % or above {:.0} %; needs {:.0} s of braking.",
        100.0 * friction.ratio_watch_low,
        100.0 * friction.ratio_watch_high,
        100.0 * friction.ratio_act_low,
        100.0 * friction.ratio_act_high,
        friction.min_braking_s
    );
    vec![
        Meaning {
            id: "brake-friction",
            name: "Pad friction",
            block: "health assessment",
            is: "Friction between pad and disc, mean over the latest braking, of the wagon and of each wheelset. Estimated from wheel speeds, train speed and brake-cylinder pressure; nothing measures it.",
            unit: "none (a ratio of forces)",
            interval: "95 %, from the filter and the scatter over blocks of braking, widened by what mass and wheel radii may be wrong",
            limits: ratio.clone(),
            blind: "Anything while the pads are off: the figure is held. Of a single wheelset only braking counts in which the filter can tell it from the other one. A wrong mass shifts all of them alike.",
        },
        Meaning {
            id: "standard",
            name: "Pad friction at standard conditions",
            block: "health assessment",
            is: "What the pad friction would be at a standard speed, pressing force and disc temperature: a fit over the braking takes their influence out, so that mornings can be compared with each other.",
            unit: "none",
            interval: "95 %, from the fit",
            limits: format!(
                "As pad friction. Standard is {:.0} km/h, {:.0} kN a wheelset and discs {:.0} K above their surroundings.",
                3.6 * set.standard.speed_m_s,
                1e-3 * set.standard.pressing_force_n,
                set.standard.disc_rise_k
            ),
            blind: "The disc's temperature is worked out, not measured. Braking that is always alike cannot show what conditions do; the interval stays wide then.",
        },
        Meaning {
            id: "asymmetry",
            name: "Front minus rear",
            block: "health assessment",
            is: "Pad friction of the front wheelsets minus that of the rear ones, over their mean.",
            unit: "% of the mean",
            interval: "95 %",
            limits: format!(
                "Watch beyond ±{:.0} %, act beyond ±{:.0} %, by the end of the interval that is nearer to zero.",
                100.0 * set.asymmetry.watch,
                100.0 * set.asymmetry.act
            ),
            blind: "While both wheelsets roll, speeds show the sum of their torques; the split shows in creepage as far as the wheel radii are known, and in slides.",
        },
        Meaning {
            id: "response",
            name: "Brake builds up in",
            block: "state detection",
            is: "Time from the first pressing force to 90 % of its level, median of the latest brake applications that came to rest.",
            unit: "s",
            interval: "spread of the latest applications",
            limits: format!(
                "Watch above {:.1} s, act above {:.1} s.",
                set.response.watch_s, set.response.act_s
            ),
            blind: "The time from the driver's action to the first pressure here, and applications that never come to rest.",
        },
        Meaning {
            id: "delay",
            name: "Begins later than its place",
            block: "state detection",
            is: "When the first pressing force comes on this wagon, against a line through the beginnings on all wagons: the signal travels along the brake pipe, and what remains is the delay of the wagon. Median of its latest applications.",
            unit: "s",
            interval: "spread of the latest applications",
            limits: format!(
                "Watch above {:.1} s, act above {:.1} s, by the middle between median and lowest; needs three applications.",
                set.response.late_watch_s, set.response.late_act_s
            ),
            blind: "A delay of the whole train, and one that bends evenly along it.",
        },
        Meaning {
            id: "dragging",
            name: "Drag when released",
            block: "state detection",
            is: "Force that holds the wagon back while its brakes are released, beyond running resistance and gradient.",
            unit: "kN",
            interval: "95 %, with what wind, load and gradient may be",
            limits: format!(
                "Watch above {:.1} %, act above {:.1} % of the weight, by the lower end; needs {:.0} s of released running.",
                100.0 * set.dragging.watch,
                100.0 * set.dragging.act,
                set.dragging.min_released_s
            ),
            blind: "In a coupled train the couplers spread the drag of one wagon over all of them: then all wagons show a part of it.",
        },
        Meaning {
            id: "isolated",
            name: "Without a brake",
            block: "state detection",
            is: "Share of the latest braking during which a wheelset had no pressing force while others of the wagon had, or the whole wagon while the other wagons had; or pads that press without any effect.",
            unit: "% of the braking time",
            interval: "none: it is counted",
            limits: format!(
                "Watch above {:.0} %, act above {:.0} %; act also when friction is surely below {:.0} % of nominal.",
                100.0 * set.isolated.watch,
                100.0 * set.isolated.act,
                100.0 * set.isolated.effect_ratio
            ),
            blind: "A whole wagon that is cut off in a train of fewer than three wagons, or when half of them are.",
        },
    ]
}

fn rail(limits: &Limits) -> Vec<Meaning> {
    let set = &limits.settings;
    vec![
        Meaning {
            id: "utilised",
            name: "Adhesion used",
            block: "manipulation",
            is: "Tangential over normal force between wheel and rail: the largest of the latest seconds.",
            unit: "none",
            interval: "95 %, from the filter",
            limits: format!("Not judged; over the latest {:.0} s.", set.adhesion.window_s),
            blind: "How much more the rail would have given.",
        },
        Meaning {
            id: "available",
            name: "Adhesion available",
            block: "state detection",
            is: "The most that the rail gives. While a wheelset slides it shows itself; otherwise what was used without sliding is a lower bound, marked ≥.",
            unit: "none",
            interval: "95 % of what is believed after all slides and all rolling",
            limits: format!(
                "Not judged itself: see Rail. What a slide showed holds for {:.0} s.",
                set.adhesion.slide_hold_s
            ),
            blind: "The limit while everything rolls well below it.",
        },
        Meaning {
            id: "rail",
            name: "Rail",
            block: "state detection",
            is: "Probability that the rail is dry, wet, low or very low, by Bayes' rule from slides and from rolling without a slide; without news it fades to what is usual.",
            unit: "% probability",
            interval: "the probabilities say it themselves",
            limits: format!(
                "Watch from {:.0} % low or very low on, act from {:.0} % very low on, ok up to {:.0} %; in between unknown.",
                100.0 * set.adhesion.low_probability_watch,
                100.0 * set.adhesion.very_low_probability_act,
                100.0 * set.adhesion.low_probability_ok
            ),
            blind: "Why it is low: leaves, water, oil or ice. A rail that is never asked for more than it gives looks like any better one.",
        },
        Meaning {
            id: "slides",
            name: "Slides",
            block: "health assessment",
            is: "Slides counted, with the energy that went into tread and rail and the time with a locked wheelset: the risk of wheel flats.",
            unit: "number; J; s",
            interval: "none: they are counted",
            limits: format!(
                "Of one wheelset, lately: watch above {:.0} MJ or {:.0} s locked, act above {:.0} MJ or {:.0} s.",
                1e-6 * set.slides.energy_watch_j,
                set.slides.locked_watch_s,
                1e-6 * set.slides.energy_act_j,
                set.slides.locked_act_s
            ),
            blind: "The form of the wheel itself; slides shorter than a tenth of a second.",
        },
        Meaning {
            id: "wsp",
            name: "Braking with WSP",
            block: "state detection",
            is: "Share of the latest braking during which slide protection acts. On low rail it does its work, so only what it does on good rail is judged.",
            unit: "% of the braking time",
            interval: "none: it is counted",
            limits: format!(
                "On good rail: watch above {:.0} %, act above {:.0} %.",
                100.0 * set.wsp.share_watch,
                100.0 * set.wsp.share_act
            ),
            blind: "Whether it could have used the rail better.",
        },
        Meaning {
            id: "sanding",
            name: "Sand: gain of grip",
            block: "state detection",
            is: "Adhesion in slides with sand over adhesion in slides without, within a short time.",
            unit: "a factor",
            interval: "95 %, from the scatter of both",
            limits: format!("Watch when even the upper end is below {:.1}.", set.sanding.factor_watch),
            blind: "Sand that falls where nothing slides, and a rail that changes between the two.",
        },
    ]
}

fn data(limits: &Limits) -> Vec<Meaning> {
    let set = &limits.settings;
    let nis = format!(
        "Watch above {} or below {}, act above {}. Nothing is judged below {} m/s.",
        set.filter.nis_watch_high,
        set.filter.nis_watch_low,
        set.filter.nis_act_high,
        set.filter.min_speed_m_s
    );
    vec![
        Meaning {
            id: "sensors",
            name: "Faulty sensor values",
            block: "acquisition",
            is: "Share of sensor values that are missing, refused by the filter, frozen or dead; the sensors are named.",
            unit: "% of the values",
            interval: "none: they are counted",
            limits: format!(
                "Watch above {:.0} %, act above {:.0} % or when a sensor is dead.",
                100.0 * set.sensors.faulty_share_watch,
                100.0 * set.sensors.faulty_share_act
            ),
            blind: "A sensor that is wrong by a little, and an error that all sensors share.",
        },
        Meaning {
            id: "filter",
            name: "Filter",
            block: "manipulation",
            is: "Mean normalised innovation squared over its degrees of freedom, over the latest seconds: how far the data are from what the filter expects, by its own measure. 1 is ideal.",
            unit: "none",
            interval: "none",
            limits: nis,
            blind: "A mismatch that another state takes up: the figures are wrong then and nothing looks wrong.",
        },
        Meaning {
            id: "model",
            name: "Model over time",
            block: "health assessment",
            is: "The same over minutes, watched by output and by what the wagon does; where it stays too large, the term of the equations to suspect is named and the latest minutes are kept as a recording for `railgrip gap diagnose`.",
            unit: "none",
            interval: "none",
            limits: "By a sequential test against chance; it speaks through the alert of the filter."
                .to_owned(),
            blind: "As for the filter.",
        },
        Meaning {
            id: "age",
            name: "Age of the data",
            block: "acquisition",
            is: "Time since the sample behind a figure was taken, by a clock that nobody sets.",
            unit: "s",
            interval: "none",
            limits: "Beyond the limit of the config a wagon is stale: nothing of it passes for the present."
                .to_owned(),
            blind: "A data source that repeats old samples as new ones.",
        },
    ]
}

fn train(limits: &Limits) -> Vec<Meaning> {
    let (full, response, cell, memory) = limits.capability.as_ref().map_or((0.0, 0.0, 0.0, 0.0), |set| {
        (set.full_deceleration_m_s2, set.response_s, set.cell_m, set.map_memory_s)
    });
    vec![
        Meaning {
            id: "stopping",
            name: "Stopping distance now",
            block: "advisory",
            is: "How far the train runs from a speed under full braking: each wagon brakes with the lesser of what its pads give and what its rail takes, forces and masses add, running resistance helps.",
            unit: "m",
            interval: "95 %: pads err independently from wagon to wagon, the rail is the same for all; unknown pads count as 70 to 110 % of nominal",
            limits: format!(
                "By the lower end: watch above {:.0} %, act above {:.0} % of the nominal distance. Full braking is {full:.2} m/s² after {response:.1} s. No alert of its own: what lengthens it has one.",
                100.0 * WATCH_RATIO,
                100.0 * ACT_RATIO
            ),
            blind: "Gradients ahead, magnetic track brakes, and that slide protection uses less than the rail gives. It is no brake test.",
        },
        Meaning {
            id: "map",
            name: "Adhesion along the track",
            block: "state detection",
            is: "The same belief as Rail for each stretch of the track, from every wagon that passed: each one makes it more certain.",
            unit: "none, by kilometre",
            interval: "95 %",
            limits: format!(
                "A stretch is called low from 50 % probability on. Cells of {cell:.0} m; what they know fades in about {:.0} min.",
                memory / 60.0
            ),
            blind: "Stretches on which nobody braked or pulled; a restart of the service forgets the map.",
        },
        Meaning {
            id: "trend",
            name: "Trend and time left",
            block: "prognosis",
            is: "Median of the slopes of all pairs of stored points (Theil and Sen) over 30 days of hours, or over less while there is less; the time left is where that line meets the limit of act.",
            unit: "per day; days",
            interval: "95 %, from Kendall's statistic, widened because neighbours resemble each other",
            limits: "A trend is called one only when the interval of its slope does not hold zero; \"no trend\" is an answer.".to_owned(),
            blind: "What does not go on as it did: a pad that is changed, a season. Fewer than eight points, or less than an hour, show nothing.",
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every link from an indicator to its meaning must lead somewhere.
    #[test]
    fn every_figure_of_the_wagon_page_has_a_meaning() {
        let text = body(&Limits::default()).into_string();
        let page = include_str!("wagon.rs");
        let linked = page.split("Row::new(").skip(1).filter_map(|call| call.split('"').nth(3));
        let mut count = 0;
        for id in linked.chain(["rail", "stopping", "map", "trend", "age"]) {
            assert!(text.contains(&format!("id=\"{id}\"")), "{id}");
            count += 1;
        }
        assert!(count > 20, "{count}");
    }
}
