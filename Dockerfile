# The figures and the check of the replication in a clean system:
#   docker build -t stickslip-replication .
#   docker run --rm stickslip-replication
# The image has the compiler that rust-toolchain.toml names.
FROM rust:1.95.0-bookworm
COPY . /replication
WORKDIR /replication
RUN make figures
CMD ["cargo", "test", "--locked"]
