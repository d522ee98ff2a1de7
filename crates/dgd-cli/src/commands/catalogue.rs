//! `dgd catalogue`: what a diagnosis of a return line can name, and which of its steps can be left out.

use crate::args::Global;
use crate::failure::Failure;
use crate::say::{self, TextTable};
use dgd_diagnose::Step;
use dgd_effects::{About, Method, catalogue};
use serde_json::{Value, json};

pub(crate) fn run(global: &Global) -> Result<String, Failure> {
    Ok(if global.json {
        say::json(&as_json())
    } else {
        tell()
    })
}

fn effects() -> impl Iterator<Item = &'static About> {
    catalogue().iter().map(|effect| effect.about())
}

fn tell() -> String {
    let mut table = TextTable::new(["effect", "relation", "what it is"]);
    for about in effects() {
        table.row([about.id, about.relation.name(), about.title].map(str::to_owned));
    }
    let steps: Vec<&str> = Step::ALL.iter().map(|s| s.name()).collect();
    format!(
        "{} that `dgd diagnose --well` can name (`--suspect` fits only those given)\n{}\n{} of its search that `--without` can omit\n  \
         {}\n\nThe effects of a system depend on its components: `dgd system check` lists them.\n",
        say::counted(catalogue().len(), "effect"),
        table.render(),
        say::counted(steps.len(), "step"),
        steps.join(", "),
    )
}

fn as_json() -> Value {
    let parameters = |about: &About| -> Vec<Value> {
        let one = |p: &dgd_effects::Parameter| json!({ "name": p.name, "meaning": p.meaning });
        about.parameters.iter().map(one).collect()
    };
    json!({
        "schema": "dgd.catalogue/1",
        "effects": effects()
            .map(|about| json!({
                "effect": about.id,
                "title": about.title,
                "relation": about.relation.name(),
                "parameters": parameters(about),
                "equation": about.equation,
                "source": about.source,
                "excited_by": about.excited_by,
                "size_error": (about.search.method == Method::Relations).then_some(about.search.size_error),
            }))
            .collect::<Vec<_>>(),
        "steps": Step::ALL.iter().map(|s| s.name()).collect::<Vec<_>>(),
    })
}
