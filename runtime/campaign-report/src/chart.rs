//! Charts as SVG, by plotters.

use std::f64::consts::LN_10;

use backseat_units::EastNorth;
use backseat_units::math::{exp, ln};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::ReportError;
use crate::figure::figure;
use crate::statistics::quantile;

/// Okabe and Ito's colours, which people with any colour vision can tell apart.
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(213, 94, 0),
    RGBColor(90, 90, 90),
];
const SIZE: (u32, u32) = (640, 300);
const TEXT: (&str, u32) = ("sans-serif", 13);

/// A named series of values.
pub(crate) struct Series<'a, T> {
    pub(crate) name: &'a str,
    pub(crate) values: Vec<T>,
}

/// An area of a map: a zone's ring.
pub(crate) struct Ring {
    pub(crate) points: Vec<EastNorth>,
    pub(crate) keep_out: bool,
}

fn color(place: usize) -> RGBColor {
    COLORS[place % COLORS.len()]
}

fn failed(error: impl std::fmt::Display) -> ReportError {
    ReportError::Chart(error.to_string())
}

/// How often values occur, in each series; all series have the same bins.
pub(crate) fn distributions(title: &str, series: &[Series<'_, f64>]) -> Result<Option<String>, ReportError> {
    let all = series.iter().flat_map(|series| series.values.iter().copied());
    let Some((least, most)) = ends(all) else {
        return Ok(None);
    };
    let longest = series.iter().map(|series| series.values.len()).max().unwrap_or(0);
    let bins = ((longest as f64).sqrt() as usize).clamp(8, 50);
    let (from, to) = if least < most {
        (least, most)
    } else {
        let half = 0.5 * least.abs().max(1.0);
        (least - half, most + half)
    };
    let width = (to - from) / bins as f64;
    let shares: Vec<Vec<f64>> = series
        .iter()
        .map(|series| {
            let mut counts = vec![0u64; bins];
            for value in &series.values {
                counts[(((value - from) / width) as usize).min(bins - 1)] += 1;
            }
            let total = series.values.len().max(1) as f64;
            counts.iter().map(|count| 100.0 * *count as f64 / total).collect()
        })
        .collect();
    let top = shares.iter().flatten().copied().fold(0.0, f64::max) * 1.05;
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let mut chart = ChartBuilder::on(&root)
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(50)
            .build_cartesian_2d(from..to, 0.0..top)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc(title)
            .y_desc("runs, %")
            .x_label_formatter(&|value| figure(*value))
            .label_style(TEXT)
            .draw()
            .map_err(failed)?;
        for (place, (series, shares)) in series.iter().zip(&shares).enumerate() {
            let steps = shares.iter().enumerate().flat_map(|(bin, share)| {
                let left = from + width * bin as f64;
                [(left, *share), (left + width, *share)]
            });
            chart
                .draw_series(
                    AreaSeries::new(steps, 0.0, color(place).mix(0.2)).border_style(color(place).stroke_width(2)),
                )
                .map_err(failed)?
                .label(series.name)
                .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 12, y + 5)], color(place).filled()));
        }
        if series.len() > 1 {
            chart
                .configure_series_labels()
                .background_style(WHITE.mix(0.8))
                .border_style(TRANSPARENT)
                .label_font(TEXT)
                .position(SeriesLabelPosition::UpperRight)
                .draw()
                .map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(Some(text))
}

/// How the values of each series are spread, a row each, on one axis: a line from 5 to 95 % of the runs, a box over the
/// middle half, and a tick at the median. The values are in ascending order.
pub(crate) fn spreads(title: &str, series: &[Series<'_, f64>]) -> Result<Option<String>, ReportError> {
    const ROW: u32 = 26;
    let rows: Vec<(&str, [f64; 5])> = series
        .iter()
        .filter(|series| !series.values.is_empty())
        .map(|series| {
            let shares = [0.05, 0.25, 0.5, 0.75, 0.95];
            (series.name, shares.map(|share| quantile(&series.values, share)))
        })
        .collect();
    let Some((from, to)) = ends(rows.iter().flat_map(|(_, values)| *values)).map(roomy) else {
        return Ok(None);
    };
    let mut text = String::new();
    {
        let height = 60 + ROW * rows.len() as u32;
        let root = SVGBackend::with_string(&mut text, (SIZE.0, height)).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let count = rows.len() as f64;
        let mut chart = ChartBuilder::on(&root)
            .margin(12)
            .x_label_area_size(40)
            // For the names.
            .margin_left(180)
            .build_cartesian_2d(from..to, 0.0..count)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .disable_y_mesh()
            .y_labels(0)
            .light_line_style(TRANSPARENT)
            .x_desc(title)
            .x_label_formatter(&|value| figure(*value))
            .label_style(TEXT)
            .draw()
            .map_err(failed)?;
        for (place, (name, [least, low, median, high, most])) in rows.iter().enumerate() {
            let middle = count - place as f64 - 0.5;
            let color = color(place);
            let line = PathElement::new([(*least, middle), (*most, middle)], color.stroke_width(2));
            let tick = PathElement::new(
                [(*median, middle - 0.32), (*median, middle + 0.32)],
                color.stroke_width(3),
            );
            let within = Rectangle::new([(*low, middle - 0.3), (*high, middle + 0.3)], color.mix(0.35).filled());
            chart.draw_series([line, tick]).map_err(failed)?;
            chart.draw_series([within]).map_err(failed)?;
            let (x, y) = chart.backend_coord(&(from, middle));
            let short: String = name.chars().take(26).collect();
            let style = TEXT.into_text_style(&root).pos(Pos::new(HPos::Right, VPos::Center));
            root.draw(&Text::new(short, (x - 8, y), style)).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(Some(text))
}

/// A measure over a parameter, one point a run. A parameter that is even in its logarithm gets such an axis.
pub(crate) fn scatter(
    across: &str,
    up: &str,
    logarithmic: bool,
    series: &[Series<'_, (f64, f64)>],
) -> Result<Option<String>, ReportError> {
    let place = |x: f64| if logarithmic { ln(x) / LN_10 } else { x };
    let value = |place: f64| if logarithmic { exp(place * LN_10) } else { place };
    let xs = ends(
        series
            .iter()
            .flat_map(|series| series.values.iter().map(|at| place(at.0))),
    );
    let ys = ends(series.iter().flat_map(|series| series.values.iter().map(|at| at.1)));
    let (Some(xs), Some(ys)) = (xs, ys) else {
        return Ok(None);
    };
    let (xs, ys) = (roomy(xs), roomy(ys));
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let mut chart = ChartBuilder::on(&root)
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d(xs.0..xs.1, ys.0..ys.1)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc(across)
            .y_desc(up)
            .x_label_formatter(&|at| figure(value(*at)))
            .y_label_formatter(&|value| figure(*value))
            .label_style(TEXT)
            .draw()
            .map_err(failed)?;
        for (number, series) in series.iter().enumerate() {
            let points = series
                .values
                .iter()
                .map(|at| Circle::new((place(at.0), at.1), 2, color(number).mix(0.6).filled()));
            chart.draw_series(points).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(Some(text))
}

/// Which share of something each name has, as bars from the top down.
pub(crate) fn bars(across: &str, shares: &[(String, f64)]) -> Result<String, ReportError> {
    let height = 60 + 26 * shares.len() as u32;
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (SIZE.0, height)).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let count = shares.len() as f64;
        let mut chart = ChartBuilder::on(&root)
            .margin(12)
            .x_label_area_size(40)
            .build_cartesian_2d(0.0..1.0, 0.0..count)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .disable_y_mesh()
            .y_labels(0)
            .light_line_style(TRANSPARENT)
            .x_desc(across)
            .x_label_formatter(&|value| format!("{:.0} %", 100.0 * value))
            .label_style(TEXT)
            .draw()
            .map_err(failed)?;
        for (place, (name, share)) in shares.iter().enumerate() {
            let top = count - place as f64;
            let bar = Rectangle::new([(0.0, top - 0.9), (*share, top - 0.1)], color(0).mix(0.5).filled());
            chart.draw_series([bar]).map_err(failed)?;
            let label = Text::new(name.clone(), (0.01, top - 0.3), TEXT);
            chart.draw_series([label]).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(text)
}

/// Tracks over the zones of a fence, north up, one metre as long in both directions.
pub(crate) fn tracks(rings: &[Ring], series: &[Series<'_, Vec<EastNorth>>]) -> Result<Option<String>, ReportError> {
    let points = || {
        let tracks = series.iter().flat_map(|series| series.values.iter().flatten());
        rings.iter().flat_map(|ring| &ring.points).chain(tracks)
    };
    let easts = ends(points().map(|at| at.east_m));
    let norths = ends(points().map(|at| at.north_m));
    let (Some(easts), Some(norths)) = (easts, norths) else {
        return Ok(None);
    };
    let (easts, norths) = (roomy(easts), roomy(norths));
    const WIDTH: u32 = 900;
    const BESIDE: f64 = 90.0;
    let scale = (f64::from(WIDTH) - BESIDE) / (easts.1 - easts.0);
    let height = (scale * (norths.1 - norths.0) + 70.0).clamp(200.0, 1000.0);
    // A tall area is drawn narrower.
    let scale = scale.min((height - 70.0) / (norths.1 - norths.0));
    let width = scale * (easts.1 - easts.0) + BESIDE;
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (width as u32, height as u32)).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let mut chart = ChartBuilder::on(&root)
            .margin(10)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d(easts.0..easts.1, norths.0..norths.1)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc("east, m")
            .y_desc("north, m")
            .x_label_formatter(&|value| format!("{value:.0}"))
            .y_label_formatter(&|value| format!("{value:.0}"))
            .label_style(TEXT)
            .draw()
            .map_err(failed)?;
        let at = |point: &EastNorth| (point.east_m, point.north_m);
        for ring in rings {
            let mut points: Vec<(f64, f64)> = ring.points.iter().map(at).collect();
            if ring.keep_out {
                chart
                    .draw_series([Polygon::new(points.clone(), RGBColor(200, 30, 30).mix(0.15))])
                    .map_err(failed)?;
            }
            points.extend(points.first().copied());
            let style = if ring.keep_out {
                RGBColor(200, 30, 30).stroke_width(1)
            } else {
                RGBColor(30, 120, 60).stroke_width(2)
            };
            chart.draw_series([PathElement::new(points, style)]).map_err(failed)?;
        }
        for (place, series) in series.iter().enumerate() {
            let tracks = series
                .values
                .iter()
                .map(|track| PathElement::new(track.iter().map(at).collect::<Vec<_>>(), color(place).mix(0.5)));
            chart
                .draw_series(tracks)
                .map_err(failed)?
                .label(series.name)
                .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 14, y)], color(place).stroke_width(2)));
        }
        chart
            .configure_series_labels()
            .background_style(WHITE.mix(0.8))
            .border_style(TRANSPARENT)
            .label_font(TEXT)
            .draw()
            .map_err(failed)?;
        root.present().map_err(failed)?;
    }
    Ok(Some(text))
}

fn ends(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.is_finite()).fold(None, |ends, value| {
        let (least, most) = ends.unwrap_or((value, value));
        Some((value.min(least), value.max(most)))
    })
}

/// The ends with some room beside them.
fn roomy((least, most): (f64, f64)) -> (f64, f64) {
    let room = if least < most {
        0.04 * (most - least)
    } else {
        0.5 * least.abs().max(1.0)
    };
    (least - room, most + room)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_are_drawn_of_anything_finite() {
        for values in [vec![], vec![1.0], vec![1.0, 1.0], vec![-1e9, 1e9], vec![0.0, 1e-12]] {
            let pairs: Vec<(f64, f64)> = values.iter().map(|value| (*value, *value)).collect();
            let series = [Series {
                name: "a",
                values: values.clone(),
            }];
            assert_eq!(spreads("m", &series).unwrap().is_none(), values.is_empty());
            let drawn = distributions("m", &series).unwrap();
            assert_eq!(drawn.is_none(), values.is_empty());
            let series = [Series {
                name: "a",
                values: pairs,
            }];
            assert_eq!(scatter("p", "m", false, &series).unwrap().is_none(), values.is_empty());
        }
        assert!(bars("share", &[("<a>".to_owned(), 0.5)]).unwrap().contains("&lt;a&gt;"));
    }

    #[test]
    fn a_logarithmic_axis_is_labelled_with_the_values() {
        let values = vec![(0.01, 1.0), (1.0, 2.0), (100.0, 3.0)];
        let series = [Series { name: "a", values }];
        let drawn = scatter("p", "m", true, &series).unwrap().unwrap();
        let labelled = |text: &str| drawn.lines().any(|line| line.trim() == text);
        assert!(labelled("0.01") && labelled("1") && labelled("100"), "{drawn}");
    }

    #[test]
    fn a_chart_of_the_same_values_is_the_same() {
        let draw = || {
            let values = vec![1.0, 2.0, 2.5, 7.0];
            distributions("m", &[Series { name: "a", values }]).unwrap()
        };
        assert_eq!(draw(), draw());
    }
}
