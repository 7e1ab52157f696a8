MODULE Signals
    ! Interrupts and signals: what RobotWare knows, never run.
    VAR intnum i{2};
    PERS bool b;
    VAR bool f;
    VAR num n;
    VAR dnum d;
    VAR string s;

    PROC main()
        CONNECT i{1} WITH tr;
        ISignalDI\SingleSafe,diX,1,i{1};
        ISignalAI aiX,AIO_BETWEEN,3,1,0\DPos,i{2};
        IPers\Single,b,i{1};
        IError COMMON_ERR\ErrorId:=5,TYPE_ERR,i{2};
        ITimer 5,i{2};
        IF diX=1 AND doX=0 OR giX>3 SetGO goX,giX;
        SetGO goX,d;
        PulseDO\High\PLength:=0.5,doX;
        WaitDI diX,high\MaxTime:=5\TimeFlag:=f;
        WaitUntil diX=1\Visualize\Header:="x";
        InvertDO doX;
        SetAO aoX,aiX/2;
        n:=DOutput(doX)+GInput(giX);
        d:=GInputDnum(giX)+5;
    ENDPROC

    TRAP tr
        VAR trapdata td;
        VAR errdomain ed;
        VAR num id;
        VAR errtype et;
        GetTrapData td;
        ReadErrData td,ed,id,et\Str1:=s;
    ENDTRAP
ENDMODULE
