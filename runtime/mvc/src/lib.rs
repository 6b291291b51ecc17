//! A mock of the Bluefin main vehicle computer: mission executive, vehicle, sensors, SPI server side.
