use crate::channel::Channel;
use crate::measures;
use crate::view::Topic;

/// The name and the text of the JSON schema of a topic that a [`crate::Listener`] is told of; `None` for other topics.
#[must_use]
pub fn schema_of(topic: &str) -> Option<(String, String)> {
    if let Some(channel) = Channel::from_topic(topic) {
        let (name, schema) = channel.schema();
        return Some((name.to_owned(), schema.to_owned()));
    }
    if topic.starts_with("/measures/") {
        return Some((measures::SCHEMA.to_owned(), measures::schema().to_string()));
    }
    Topic::all().find(|derived| derived.name() == topic).map(Topic::schema)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_topic_has_the_schema_of_the_log() {
        assert_eq!(Topic::all().count(), Topic::COUNT);
        for (place, topic) in Topic::all().enumerate() {
            assert_eq!(topic.place(), place, "{topic:?}");
            assert_eq!(schema_of(&topic.name()), Some(topic.schema()));
        }
        for channel in Channel::ALL {
            let (name, _) = schema_of(channel.topic()).expect("it has one");
            assert!(name.starts_with("backseat."), "{name}");
        }
        assert_eq!(
            schema_of("/measures/isobath/slope").map(|(name, _)| name).as_deref(),
            Some("backseat.Measure")
        );
        assert_eq!(schema_of("/nothing"), None);
    }
}
