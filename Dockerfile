# An image that runs column-hpc:
#
#     docker build -t column-hpc .
#     docker run --rm column-hpc --help
#     docker run --rm -v "$PWD:/data" -w /data --entrypoint mpirun column-hpc -n 2 column-hpc cases/wtnv146/case.yaml
#
# Debian 12's own rustc is too old, hence the first stage's base. scripts/docker_replay.sh replays
# these lines where no container engine runs; it knows FROM, WORKDIR, ENV, USER, COPY and RUN.

FROM rust:1.95-slim-bookworm AS build
RUN useradd --create-home --uid 1000 column && mkdir /build && chown column /build
WORKDIR /build
COPY scripts/setup.sh scripts/
RUN scripts/setup.sh
COPY --chown=column . .
USER column
RUN cargo build --release --locked --bin column-hpc

FROM debian:bookworm-slim
RUN apt-get update \
    && apt-get install -y --no-install-recommends \
        libpetsc-real3.18 libopenmpi3 openmpi-bin libmetis5 libhdf5-openmpi-103-1 libopenblas0-serial \
    && rm -rf /var/lib/apt/lists/*
RUN useradd --create-home --uid 1000 column
COPY --from=build /build/target/release/column-hpc /usr/local/bin/
ENV OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 \
    OMPI_MCA_hwloc_base_binding_policy=none \
    OMPI_MCA_rmaps_base_oversubscribe=1 \
    OMPI_MCA_mpi_yield_when_idle=1 \
    OMPI_MCA_btl_vader_single_copy_mechanism=none
USER column
WORKDIR /home/column
COPY --chown=column cases cases
ENTRYPOINT ["column-hpc"]
CMD ["--help"]
