# colonysim with physics and plots, compiled; `docker build -t colonysim .`, then
#   docker run --rm -v "$PWD/runs:/home/colony/runs" colonysim run hard --backend physics
FROM python:3.13-slim AS built
RUN apt-get update && apt-get install -y --no-install-recommends g++ && rm -rf /var/lib/apt/lists/*
COPY . /source
RUN python -m venv /venv \
    && COLONYSIM_COMPILE=1 PIP_CONSTRAINT=/source/constraints.txt /venv/bin/pip install --no-cache-dir '/source[physics,plot,sweep,video]'

FROM python:3.13-slim
COPY --from=built /venv /venv
ENV PATH=/venv/bin:$PATH
RUN useradd --create-home colony
USER colony
WORKDIR /home/colony
ENTRYPOINT ["colonysim"]
CMD ["--help"]
