import pytest
from backseat import SpiError, spi


def test_a_sentence_becomes_a_dict_and_a_sentence_again():
    line = "$BFCTL,081025.987,1*78"
    decoded = spi.decode(line)
    assert decoded == {"name": "BFCTL", "checksum": "valid", "message": {"created": "08:10:25.987", "granted": True}}
    assert spi.encode("BFCTL", **decoded["message"]) == line + "\r\n"
    assert spi.decode(line.encode()) == decoded
    assert spi.encode("BPLOG", message="NVG", on=True) == "$BPLOG,NVG,ON*08\r\n"


def test_the_examples_of_the_catalogue_go_there_and_back():
    messages = spi.catalogue()
    assert len(messages) == 71
    for message in messages:
        decoded = spi.decode(message["example"])
        assert spi.decode(spi.encode(decoded["name"], **decoded["message"])) == decoded
    assert [message["name"] for message in spi.catalogue("CTL")] == ["BFCTL"]


def test_what_is_no_sentence_raises_one_line():
    for line, part in [
        ("hello", "found no sentence"),
        ("$BFCTL,081025.987,1*78\r\n$BFCTL,081025.987,0*79\r\n", "found 2 sentences"),
        ("$BFCTL,081025.987,1*77", "78 is right"),
        ("$BFCTL,081025.987,7", "granted"),
    ]:
        with pytest.raises(SpiError, match=part) as raised:
            spi.decode(line)
        assert "\n" not in str(raised.value)
    assert spi.decode("$BFCTL,081025.987,1*77", ignore_checksum=True)["checksum"] == "invalid"
    with pytest.raises(SpiError, match="on"):
        spi.encode("BPLOG", message="NVG", on="perhaps")
    with pytest.raises(SpiError):
        spi.catalogue("NOTHING")


def test_all_sentences_of_a_text_are_decoded_and_invalid_ones_say_why():
    first, second = spi.decode_all("noise $BFCTL,081025.987,1*78\r\n$BFCTL,081025.987,7\r\n")
    assert first["message"]["granted"] is True and "message" not in second and second["error"]
