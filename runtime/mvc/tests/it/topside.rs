use crate::fields::of;
use crate::files::CALM;
use crate::payload::{ME, Payload};

fn with(topside: &str) -> String {
    CALM.replace("[spi]", &format!("[topside]\n{topside}\n[spi]"))
}

// SPI 7.3: "a 'success' acknowledgement indicates that the requested message was successfully queued for transmission
// by an available communications link. It does *not* indicate that the message was actually received on the topside."
#[test]
fn a_message_is_acknowledged_when_it_is_queued_and_delivered_later() {
    let mut payload = Payload::connected(&with("delivery_s = 4"), 1, &["ACK"]);
    payload.until(20.0);
    payload.say("$BPTOP,070000.000,0,target found,0");
    payload.say("$BPTOP,070001.000,3,another,");
    payload.say("$BPTOP,070002.000,3,a third");
    assert_eq!(
        payload.heard(),
        [
            "$BFACK,080020.000,TOP,070000.000,0,2,0,queued",
            "$BFACK,080020.000,TOP,070001.000,0,2,0,queued",
            "$BFACK,080020.000,TOP,070002.000,0,2,0,queued"
        ]
    );
    payload.log();
    payload.until(23.9);
    assert_eq!(payload.log(), Vec::<String>::new());
    payload.until(33.0);
    // The vehicle uses whichever link there is: the field is advice, and unimplemented.
    assert_eq!(
        payload.log(),
        [
            "24.000 s: delivered to the topside by acoustic modem: target found",
            "28.000 s: delivered to the topside by acoustic modem: another",
            "32.000 s: delivered to the topside by acoustic modem: a third"
        ]
    );
}

// "it is possible that an immediate, initial 'pending' acknowledgement will be returned prior to the actual
// success/failure acknowledgement."
#[test]
fn a_message_may_be_pending_first() {
    let text = CALM.replace(
        "acknowledge = \"immediate\"",
        "acknowledge = \"pending\"\npending_s = 1",
    );
    let mut payload = Payload::connected(&text, 1, &["ACK"]);
    payload.until(5.0);
    payload.say("$BPTOP,070000.000,3,hello,0");
    payload.until(7.1);
    assert_eq!(
        payload.heard(),
        [
            "$BFACK,080005.000,TOP,070000.000,0,3,0,",
            "$BFACK,080006.000,TOP,070000.000,0,2,0,queued"
        ]
    );
}

#[test]
fn meaningless_fields_are_invalid() {
    let mut payload = Payload::connected(&with(""), 1, &["ACK"]);
    for (said, answer) in [
        (
            "$BPTOP,070000.000,7,hello,0",
            "TOP,070000.000,0,0,0,slowest 7: expected 0 to 3",
        ),
        ("$BPTOP,070000.000,3,,0", "TOP,070000.000,0,0,0,text: empty"),
        // "Reserved for future specification. Must be empty or 0": here perhaps because of a comma in the text.
        (
            "$BPTOP,070000.000,3,hello,world",
            "TOP,070000.000,0,0,0,reserved field world: expected empty or 0",
        ),
        (
            "$BPTMR,070000.000,9,abort",
            "TMR,070000.000,0,0,0,transport 9: expected 0 to 3",
        ),
    ] {
        payload.say(said);
        assert_eq!(payload.heard(), [format!("$BFACK,080000.000,{answer}")], "{said}");
    }
}

#[test]
fn a_full_queue_refuses_a_message_and_silence_holds_the_queue() {
    let text = with("queue_max = 2\ndelivery_s = 1").replace("[start]", "[start]\ndepth_m = 10");
    let text = text.replace("starts_after_s = 1", "starts_after_s = 5000");
    let mut payload = Payload::connected(&text, 1, &["ACK"]);
    payload.say("$BPSIL,070000.000,1");
    payload.until(5.0);
    payload.heard();
    for (said, outcome) in [
        ("one", "2,0,queued"),
        ("two", "2,0,queued"),
        ("three", "1,0,too many messages wait for the topside"),
    ] {
        payload.say(&format!("$BPTOP,070001.000,3,{said},0"));
        assert_eq!(
            payload.heard(),
            [format!("$BFACK,080005.000,TOP,070001.000,0,{outcome}")]
        );
    }
    payload.log();
    payload.until(60.0);
    assert_eq!(payload.log(), Vec::<String>::new());
    payload.say("$BPSIL,070002.000,0");
    payload.until(65.0);
    let delivered = payload.log().iter().filter(|line| line.contains("delivered")).count();
    assert_eq!(delivered, 2);
}

#[test]
fn on_the_surface_the_radio_is_used() {
    let mut payload = Payload::connected(&with(""), 1, &[]);
    payload.say("$BPTOP,070000.000,3,hello,0");
    payload.until(2.5);
    assert!(
        payload
            .log()
            .iter()
            .any(|line| line.ends_with("delivered to the topside by RF modem: hello"))
    );
}

// 5.5: "Delivery of a message sent from the topside." A command message: it needs no BPLOG.
#[test]
fn the_topside_sends_messages_to_the_payload() {
    let text = CALM.to_owned()
        + r#"
[[topside.messages]]
at_s = 5
transport = "rf-modem"
text = "come home"
[[topside.messages]]
at_s = 5
transport = "acoustic-modem"
text = "now"
role = "sonar"
"#;
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.until(4.9);
    assert_eq!(payload.heard(), Vec::<String>::new());
    payload.until(5.0);
    assert_eq!(of(&payload.heard(), "BFTOP")[0], "$BFTOP,080005.000,2,come home");
    let log = payload.log();
    assert!(
        log.iter()
            .any(|line| line == "5.000 s: message from the topside by RF modem: come home")
    );
    assert!(
        log.iter()
            .any(|line| line == "5.000 s: message from the topside to sonar by acoustic modem: now")
    );
}

// 7.14: a message that came over the payload's own modem.
#[test]
fn a_relayed_message_is_logged_if_the_vehicle_accepts_it() {
    let mut payload = Payload::connected(&with(""), 1, &["ACK"]);
    payload.log();
    payload.say("$BPTMR,070000.000,3,abort");
    assert_eq!(payload.heard(), ["$BFACK,080000.000,TMR,070000.000,0,2,0,"]);
    assert_eq!(
        payload.log(),
        [format!(
            "0.000 s: {ME} relays from the topside by acoustic modem: abort"
        )]
    );
    let mut payload = Payload::connected(&with("relay = false"), 1, &["ACK"]);
    payload.say("$BPTMR,070000.000,3,abort");
    assert_eq!(
        payload.heard(),
        ["$BFACK,080000.000,TMR,070000.000,0,1,0,this vehicle takes no relayed messages"]
    );
}
