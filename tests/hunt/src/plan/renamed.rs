/// The TOML parser's message, with the new name if a table was renamed.
pub(super) fn with_new_name(message: &str) -> String {
    if message.contains("unknown field `trouble`") {
        return format!("`[[trouble]]` is called `[[fault]]` now: {message}");
    }
    message.to_owned()
}

/// The present name of a state that had another one.
pub(super) fn state(old: &str) -> Option<&'static str> {
    (old == "hold").then_some("station")
}

#[cfg(test)]
mod tests {
    use crate::plan::Plan;

    #[test]
    fn a_plan_of_before_is_refused_with_the_names_of_now() {
        let text = Plan::draw(7).to_toml();
        let state = "[[fault]]\nstate = \"hold\"\n\n[fault.ours]\nkind = \"stop\"\nfor_s = 1.0\n\n[[fault]]";
        let before = text.replace("[[fault]]", "[[trouble]]").replace("[fault.", "[trouble.");
        for (text, expected) in [
            (before, "`[[trouble]]` is called `[[fault]]` now"),
            (
                text.replacen("[[fault]]", state, 1),
                "state is \"hold\", whose name is \"station\" now",
            ),
        ] {
            let error = Plan::from_toml(&text).unwrap_err();
            let error = format!("{error:#}");
            assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        }
    }
}
