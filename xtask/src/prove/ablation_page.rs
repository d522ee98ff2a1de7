//! The page's section on what each step of the chain contributes.

use super::ablation::{Figures, OfStep, Unit, Worth, words};
use super::page::{Cell, put, table};
use super::svg::escape;

/// Nothing, where nothing was left out.
pub(crate) fn section(html: &mut String, steps: &[OfStep]) {
    if steps.is_empty() {
        return;
    }
    put!(
        html,
        "<h2>What each step contributes</h2><p>The same sealed recordings, diagnosed without each step of the chain in turn. First the figures of the whole chain, below \
         them how they change without the step: a step that contributes leaves a loss there.</p>"
    );
    let mut levels: Vec<u8> = steps.iter().map(|s| s.level).collect();
    levels.dedup();
    for level in levels {
        let own: Vec<&OfStep> = steps.iter().filter(|s| s.level == level).collect();
        let Some(first) = own.first() else { continue };
        put!(html, "<h3>Level {level}</h3>");
        let mut head = vec!["without".to_owned()];
        head.extend(Figures::titles());
        head.push("right with / without".into());
        head.push("p".into());
        let head: Vec<&str> = head.iter().map(String::as_str).collect();
        let mut cells = vec![whole(&first.whole)];
        cells.extend(own.iter().map(|s| row(s)));
        table(html, &head, &cells);
        put!(html, "<p>{}</p>", escape(&words(steps, level)));
        let silent: usize = own.iter().map(|s| s.broken).sum();
        if silent > 0 {
            put!(
                html,
                "<p class=\"quiet\">{silent} runs without a step gave no answer; they count as wrong.</p>"
            );
        }
    }
    put!(
        html,
        "<p class=\"quiet\">Single effects by severity, pairs and recordings with something outside the catalogue (unknown): share answered exactly; clean ones: share with a false \
         alarm; conf. wrong: of the findings of probability 0.9 or more; ci95: share that holds the truth; s: median seconds of a run. Differences of shares in percentage points. Right \
         with / without: cases of all sorts answered exactly with the step and not without it, and the other way round; p: chance of so uneven a split if the step did nothing (two-sided \
         sign test). A step contributes if more cases need it than are spoilt by it, or, with as many, if without it the squared errors of the probabilities are larger by more \
         than two of their standard errors, paired case by case, or the coverage lies two points further from its target; it contributes nothing if the \
         answers are the same but for trifles.</p>"
    );
}

fn whole(figures: &Figures) -> Vec<Cell> {
    let mut cells = vec![Cell::Name("(nothing)".into())];
    cells.extend(
        figures
            .list()
            .into_iter()
            .map(|(unit, value)| Cell::Number(value.map_or("–".into(), |v| unit.value(v)))),
    );
    cells
}

fn row(step: &OfStep) -> Vec<Cell> {
    let both = step.without.list().into_iter().zip(step.whole.list());
    let mut cells = vec![Cell::Name(step.step.clone())];
    cells.extend(both.map(|((unit, without), (_, with)): ((Unit, _), _)| {
        let by = without.zip(with).map(|(a, b)| unit.difference(a - b));
        Cell::Text(by.unwrap_or("–".into()))
    }));
    let change = format!("{} / {}", step.better.len(), step.worse.len());
    cells.push(match step.worth() {
        Worth::Buys => Cell::Target(Some(true), change),
        Worth::Undecided | Worth::Nothing => Cell::Text(change),
        Worth::Costs => Cell::Target(Some(false), change),
    });
    cells.push(Cell::Basis(format!("{:.2}", step.chance())));
    cells
}

#[cfg(test)]
mod tests {
    use super::super::ablation::tests::example;
    use super::*;

    #[test]
    fn every_step_has_its_row_and_what_buys_nothing_is_said() {
        let mut html = String::new();
        section(&mut html, &example());
        for step in ["edges", "form", "busiest"] {
            assert!(html.contains(&format!("<th scope=\"row\">{step}</th>")));
        }
        assert!(html.contains("contributes nothing: busiest"), "{html}");
        assert!(html.contains("✓ 1 / 0") && html.contains("✗ 0 / 1"));
        let mut none = String::new();
        section(&mut none, &[]);
        assert_eq!(none, "");
    }
}
